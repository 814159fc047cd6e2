// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/reduce.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>

#include "common/error.hpp"
#include "reducer/diagonal_form.hpp"
#include "reducer/fixed_interface_modes.hpp"
#include "reducer/interface_sets.hpp"
#include "reducer/partition.hpp"

namespace cbr {
namespace {

// Candidates for pick: participation (docs/decisions/reduction.md).
constexpr Index least_candidates = 200, candidates_per_mode = 4;
constexpr double singular_pivot = 1e-14;

// What every step of one reduction works on.
struct Reduction {
  const Mesh& mesh;
  const ReductionOptions& options;
  const ReduceSettings& settings;
  Report& report;
  FiniteElementModel model;
  Partition p;
  std::vector<Index> part;  // per model node
  Points x;                 // of the model's nodes
  ReductionFigures figures;
};

Index mesh_node(const Reduction& r, Index model_node) { return r.model.nodes[static_cast<std::size_t>(model_node)]; }

std::string node_of_interior_dof(const Reduction& r, Index dof) {
  const Index node = r.p.interior_nodes[static_cast<std::size_t>(dof / 3)];
  return name_of_node(r.mesh, r.model.nodes[static_cast<std::size_t>(node)]) + " in " + "xyz"[dof % 3];
}

SparseCholesky factorise(Reduction& r) {
  const auto phase = r.report.phase("factorisation");
  SparseCholesky factor(r.p.K_II);
  if (r.p.n_interior() == 0) return factor;
  if (!factor.ok() || factor.smallest_pivot() < singular_pivot) {
    throw InputError(
        "the stiffness of the interior is singular at " + node_of_interior_dof(r, factor.weakest_column()) +
        ": a part of it can move freely, as elements do that share only an edge or a node with the rest, or is held "
        "too weakly for a double, as very thin parts are and what an interface nearly on one line holds; mend the mesh "
        "there or put nodes of that part into the interface");
  }
  ReductionCondition& condition = r.figures.condition;
  condition.smallest_pivot = factor.smallest_pivot();
  condition.weakest = node_of_interior_dof(r, factor.weakest_column());
  condition.K_II = condition_numbers(r.p.K_II, factor);
  return factor;
}

bool has_free_modes(const ReductionOptions& options) { return options.is_massless() && options.massless_modes != "fixed"; }

void check_modes_wanted(const Reduction& r) {
  if (r.options.modes.has_value() == r.options.cutoff_hz.has_value()) {
    throw InputError(r.options.source.text() + ": exactly one of modes and cutoff_hz says how many modes are kept");
  }
  if (r.options.modes) {
    if (*r.options.modes < 0) throw InputError("modes: " + std::to_string(*r.options.modes) + " found, 0 or more allowed");
    return;
  }
  if (!(*r.options.cutoff_hz > 0) || !(*r.options.cutoff_hz < 1e100)) {
    throw InputError("cutoff_hz: " + std::to_string(*r.options.cutoff_hz) +
                     " found, a frequency in Hz above 0 and below 1e100 is allowed");
  }
}

Index n_modes_wanted(const Reduction& r, const SparseCholesky& factor) {
  check_modes_wanted(r);
  if (r.options.modes) return *r.options.modes;
  const auto phase = r.report.phase("modes: count below cutoff");
  return count_modes_below(r.p, factor, *r.options.cutoff_hz);
}

void warn_of_cut_pair(const Vector& lambda, double next, Report& report) {
  constexpr double alike = 1e-6;
  const Index k = lambda.size();
  if (k == 0 || next == 0 || next - lambda(k - 1) > alike * next) return;
  char text[256];
  std::snprintf(
      text, sizeof text,
      "modes: the last that is kept, number %lld, and the next have the same frequency (%.6g Hz, to %.0e): which of their "
      "shapes is kept depends on round-off, and so on threads and machine: keep one more, or one fewer",
      static_cast<long long>(k), std::sqrt(next) / (2 * std::numbers::pi), 1 - std::sqrt(std::max(lambda(k - 1), 0.0) / next));
  report.warning(text);
}

FixedInterfaceModes modes_to_compute(Reduction& r, const SparseCholesky& factor) {
  const Index wanted = n_modes_wanted(r, factor), n_I = r.p.n_interior();
  if (r.options.pick == "participation") {
    if (!r.options.modes) throw InputError("pick: participation needs `modes`: a cutoff keeps every mode below it");
  } else if (r.options.pick != "frequency") {
    throw InputError("pick: '" + r.options.pick + "' found, frequency or participation allowed");
  }
  const Index candidates = n_mode_candidates(r.options.pick, wanted, n_I);
  const auto phase = r.report.phase("fixed-interface modes");
  r.report.progress("fixed-interface modes", 0);
  FixedInterfaceModes modes = fixed_interface_modes(r.p, factor, candidates, r.report);
  r.report.end_progress();
  if (r.options.cutoff_hz && wanted > 0) {
    const double cutoff = 2 * std::numbers::pi * *r.options.cutoff_hz;
    if (modes.lambda(wanted - 1) > cutoff * cutoff * (1 + 1e-9)) {
      throw RunError("the eigensolver found fewer modes below the cutoff than the inertia count says: choose another cutoff");
    }
  }
  r.figures.n_candidates = candidates;
  r.figures.mode_method = modes.method;
  r.figures.modes_proven = modes.proven;
  r.figures.condition.counts = modes.counts;
  r.figures.condition.modes = check_modes(r.p, modes.lambda, modes.Phi);
  require_independent(r.p, modes.Phi, r.figures.condition.modes);
  if (r.options.modes && r.options.pick == "frequency") warn_of_cut_pair(modes.lambda, modes.next, r.report);
  return modes;
}

void keep_modes(Reduction& r, FixedInterfaceModes& modes, Condensation& condensed) {
  if (r.options.pick != "participation" || modes.lambda.size() <= *r.options.modes) return;
  const std::vector<Index> kept = modes_by_participation(condensed.M_kc, *r.options.modes);
  modes.lambda = Vector(modes.lambda(kept));
  modes.Phi = Matrix(modes.Phi(Eigen::all, kept));
  condensed.M_kc = Matrix(condensed.M_kc(kept, Eigen::all));
}

Points coordinates_of(const Reduction& r, const std::vector<Index>& nodes) {
  Points x(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < x.rows(); ++i) {
    x.row(i) = r.mesh.coordinates.row(r.model.nodes[static_cast<std::size_t>(nodes[static_cast<std::size_t>(i)])]);
  }
  return x;
}

std::vector<Index> ids_of(const Reduction& r, const std::vector<Index>& nodes) {
  std::vector<Index> ids;
  for (const Index i : nodes) ids.push_back(r.mesh.node_ids[static_cast<std::size_t>(r.model.nodes[static_cast<std::size_t>(i)])]);
  return ids;
}

// Mesh node -> its place in [interface nodes; interior nodes], or -1.
std::vector<Index> places(const Reduction& r) {
  std::vector<Index> place(r.mesh.node_ids.size(), -1);
  Index next = 0;
  for (const auto* nodes : {&r.p.interface_nodes, &r.p.interior_nodes}) {
    for (const Index i : *nodes) place[static_cast<std::size_t>(r.model.nodes[static_cast<std::size_t>(i)])] = next++;
  }
  return place;
}

void add_recovery(const Reduction& r, Matrix&& Psi, Matrix&& Phi, Superelement& s) {
  Superelement::Recovery recovery;
  recovery.node_ids = ids_of(r, r.p.interior_nodes);
  recovery.coordinates = coordinates_of(r, r.p.interior_nodes);
  recovery.Psi = std::move(Psi);
  recovery.Phi = std::move(Phi);
  if (r.p.n_interior() == 0) recovery.Psi.resize(0, r.p.n_interface()), recovery.Phi.resize(0, s.k());
  const std::vector<Index> place = places(r);
  for (const auto& block : r.mesh.blocks) {
    if (dimension(block.type) != 3) continue;
    recovery.blocks.push_back(block);
    for (Index& node : recovery.blocks.back().connectivity.reshaped()) node = place[static_cast<std::size_t>(node)];
  }
  s.recovery.push_back(std::move(recovery));
}

void describe_interface(const Reduction& r, Superelement& s) {
  s.node_ids = ids_of(r, r.p.interface_nodes);
  s.coordinates = coordinates_of(r, r.p.interface_nodes);
  for (Index i = 0; i < r.p.n_interface(); ++i) {
    s.dof_node.push_back(i / 3);
    s.dof_component.push_back(static_cast<int>(i % 3));
  }
  std::vector<Index> place = places(r);
  for (Index& i : place) i = i < static_cast<Index>(r.p.interface_nodes.size()) ? i : -1;
  add_interface_sets(r.mesh, place, r.options.interface_sets, s);
}

void keep_figures(Reduction& r, const Superelement& s, MasslessFigures&& m) {
  r.figures.highest_frequency = std::sqrt(s.eigenvalues.maxCoeff()) / (2 * std::numbers::pi);
  r.figures.massless = std::move(m);
}

// Basis massless, of the free modes; K_cc and M_cc of a condensation without modes.
void make_free(Reduction& r, const SparseCholesky& factor, Condensation& condensed, Superelement& s) {
  const auto phase = r.report.phase("free modes");
  s.K_cc = std::move(condensed.K_cc), s.M_cc = std::move(condensed.M_cc);
  MasslessFigures m = make_massless_free(
      {r.model.K, r.model.M, r.x, r.part}, r.p, factor,
      {r.options.modes.value_or(0), r.options.cutoff_hz.value_or(0), r.options.massless_modes == "tapered"}, s, r.report);
  r.figures.n_candidates = s.k();
  r.figures.mode_method = m.method, r.figures.modes_proven = m.proven;
  r.figures.condition.counts = m.counts, r.figures.condition.modes = m.modes;
  if (r.options.modes) warn_of_cut_pair(s.eigenvalues, m.next, r.report);
  keep_figures(r, s, std::move(m));
}

std::vector<Index> parts_of_interface(const Reduction& r) {
  std::vector<Index> part;
  for (const Index node : r.p.interface_nodes) part.push_back(r.part[static_cast<std::size_t>(node)]);
  return part;
}

void make_fixed(Reduction& r, Superelement& s) {
  const auto phase = r.report.phase("massless form");
  keep_figures(r, s, make_massless_fixed(parts_of_interface(r), s));
}

void condense_and_keep(Reduction& r, Superelement& s) {
  FixedInterfaceModes modes;
  Condensation condensed;
  {
    const SparseCholesky factor = factorise(r);
    r.figures.factor_nonzeros = factor.n_nonzeros();
    r.figures.factor_flops = factor.flops();
    if (has_free_modes(r.options)) {
      check_modes_wanted(r);
      modes.Phi.resize(r.p.n_interior(), 0);
    } else {
      modes = modes_to_compute(r, factor);
    }
    // From here on only its factor is needed, and the space may be.
    r.p.K_II = SparseMatrix(r.p.n_interior(), r.p.n_interior());
    CondensationOptions options;
    options.memory = panel_memory(r.settings.memory, r.p, factor, modes.Phi);
    options.way = r.settings.way;
    options.panel = r.settings.panel;
    options.keep_Psi = r.options.recovery;
    {
      const auto phase = r.report.phase("condensation");
      condensed = condense(r.p, factor, modes.Phi, options, r.report);
    }
    if (has_free_modes(r.options)) make_free(r, factor, condensed, s);
  }
  r.figures.solve_flops = condensed.solve_flops;
  r.figures.product_flops = condensed.product_flops;
  r.figures.way = condensed.way;
  r.figures.panel = condensed.panel;
  if (has_free_modes(r.options)) return;
  keep_modes(r, modes, condensed);
  s.eigenvalues = modes.lambda;
  s.K_cc = std::move(condensed.K_cc);
  s.M_cc = std::move(condensed.M_cc);
  s.M_kc = std::move(condensed.M_kc);
  if (s.k() > 0) r.figures.highest_frequency = std::sqrt(s.eigenvalues.maxCoeff()) / (2 * std::numbers::pi);
  if (r.options.is_massless()) make_fixed(r, s);
  if (r.options.recovery) add_recovery(r, std::move(condensed.Psi), std::move(modes.Phi), s);
}

void add_diagonal(Reduction& r, Superelement& s) {
  if (s.n() > r.settings.diagonal_limit) return;
  const auto phase = r.report.phase("diagonal form");
  ReductionCondition& condition = r.figures.condition;
  condition.mass = reduced_mass_condition(s);
  condition.n_rigid = add_diagonal_form(s, parts_of_interface(r));
  condition.n_zero = (s.omega.array() == 0).count();
  condition.largest_omega = s.omega(s.n() - 1);
  if (condition.n_zero < s.n()) condition.lowest_omega = s.omega(condition.n_zero);
  if (condition.n_zero == condition.n_rigid) return;
  Index dof = 0;
  s.V.col(condition.n_rigid).tail(s.c()).cwiseAbs().maxCoeff(&dof);
  condition.loose_node = name_of_node(r.mesh, mesh_node(r, r.p.interface_nodes[static_cast<std::size_t>(dof / 3)]));
}

// Of the full K, as it was assembled.
void check_rigid_motions(Reduction& r, const Vector3& center) {
  const RigidResidual rigid = rigid_residual(r.model.K, rigid_modes(r.x, center));
  r.figures.condition.rigid = rigid.value;
  if (rigid.row >= 0) r.figures.condition.rigid_node = name_of_node(r.mesh, mesh_node(r, rigid.row / 3));
}

// `interface`: mesh nodes, or none: those of the options' sets.
Superelement reduce_to(const std::vector<Index>* interface, const Mesh& mesh, const std::vector<BlockProperties>& properties,
                       MassKind mass, const ReductionOptions& options, const ReduceSettings& settings, Report& report,
                       ReductionFigures* figures) {
  Reduction r{mesh, options, settings, report, {}, {}, {}, {}, {}};
  Superelement s;
  {
    const auto phase = report.phase("assembly");
    r.model = assemble(mesh, properties, mass);
    std::vector<Index> kept;
    if (interface == nullptr) {
      kept = interface_nodes(mesh, r.model, options.interface_sets);
    } else {
      for (const Index node : *interface) kept.push_back(r.model.row[static_cast<std::size_t>(node)]);
    }
    r.p = partition(r.model, kept);
    r.part = connected_parts(mesh, r.model);
    r.x.resize(static_cast<Index>(r.model.nodes.size()), 3);
    for (Index i = 0; i < r.x.rows(); ++i) r.x.row(i) = mesh.coordinates.row(r.model.nodes[static_cast<std::size_t>(i)]);
    s.rigid_body = rigid_body(r.model.M, r.x);
    check_rigid_motions(r, s.rigid_body.center);
    r.figures.n_dofs = r.model.K.rows();
    r.figures.n_interior = r.p.n_interior();
    if (!has_free_modes(options)) r.model.K = SparseMatrix(), r.model.M = SparseMatrix();
  }
  check_interface_holds(mesh, r.model, r.p, r.part);
  describe_interface(r, s);
  s.basis = options.basis;
  condense_and_keep(r, s);
  if (options.is_massless()) {
    report_condition(r.figures.condition, report);
    if (figures != nullptr) *figures = r.figures;
    return s;
  }
  r.figures.condition.reduced_rigid = rigid_residual(s.K_cc, reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c())).value;
  require_free(r.figures.condition);
  add_diagonal(r, s);
  report_condition(r.figures.condition, report);
  if (figures != nullptr) *figures = r.figures;
  return s;
}

}  // namespace

double half_of_memory() {
  return 0.5 * static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGE_SIZE));
}

double panel_memory(double given, const Partition& p, const SparseCholesky& factor, const Matrix& Phi) {
  if (given > 0) return given;
  const auto c = static_cast<double>(p.n_interface());
  const double held =
      factor.bytes() + 32 * static_cast<double>(p.M_II.nonZeros()) + 8 * static_cast<double>(Phi.size()) + 32 * c * c;
  // Some is given in any case: without panels nothing goes
  const double all = 2 * half_of_memory();
  return std::min(0.5 * all, std::max(0.05 * all, 0.85 * all - held));
}

Index n_mode_candidates(const std::string& pick, Index wanted, Index n_interior) {
  if (pick != "participation" || wanted == 0 || wanted >= n_interior) return wanted;
  return std::min(n_interior, std::max(candidates_per_mode * wanted, least_candidates));
}

std::vector<Index> modes_by_participation(const Matrix& M_kc, Index count) {
  const Vector participation = M_kc.rowwise().squaredNorm();
  std::vector<Index> order(static_cast<std::size_t>(M_kc.rows()));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return participation(a) > participation(b); });
  order.resize(static_cast<std::size_t>(std::min<Index>(count, M_kc.rows())));
  std::sort(order.begin(), order.end());
  return order;
}

Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const ReduceSettings& settings, Report& report, ReductionFigures* figures) {
  return reduce_to(nullptr, mesh, properties, mass, options, settings, report, figures);
}

Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const std::vector<Index>& interface, const ReduceSettings& settings,
                    Report& report, ReductionFigures* figures) {
  return reduce_to(&interface, mesh, properties, mass, options, settings, report, figures);
}

}  // namespace cbr
