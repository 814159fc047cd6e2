// SPDX-License-Identifier: GPL-3.0-or-later
// The steps of a reduction in one process.
#include <algorithm>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/fem/block_elements.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/huge_pages.hpp"
#include "reducer/bases/engine.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/judgement/condition_numbers.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
namespace {

constexpr double singular_pivot = 1e-14;
constexpr double to_round_off = 1e-13;
constexpr double moves_none = 1e-9;  // of the fixed dofs, of the rigid motion that moves them most

// Of the full K, as it was assembled.
void check_rigid_motions(Reduction& r, const Vector3& center) {
  const RigidResidual rigid =
      rigid_residual(r.model.K, rigid_modes(r.x, center, r.model.n_rotations));
  r.figures.condition.rigid = rigid.value;
  if (rigid.row >= 0)
    r.figures.condition.rigid_node = name_of_node(r.mesh, mesh_node(r, rigid.row / 3));
}

// Without the copies that Eigen 3.4 makes of a sparse matrix that is assigned.
void take(FiniteElementModel&& made, FiniteElementModel& model) {
  model.K.swap(made.K);
  model.M.swap(made.M);
  model.nodes = std::move(made.nodes);
  model.row = std::move(made.row);
  model.n_rotations = made.n_rotations;
}

void require_one_part(const Reduction& r, const std::string& key) {
  if (has_parts(r))
    throw InputError(r.options.source.text() + ": reduction." + key +
                     ": the component has several parts, which nothing joins, and this needs one: "
                     "give each part a component of its own");
}

// From here on the model has the points in the place of their sets' nodes.
void take_points_in(Reduction& r) {
  if (r.settings.points.empty()) return;
  require_one_part(r, "points");
  couple_rigidly(r.mesh, r.settings.points, r.model, r.x);
  r.p.n_points = static_cast<Index>(r.settings.points.size());
  r.part.assign(r.model.nodes.size(), 0);
}

// From here on the model has no rows of fixed dofs.
void take_fixed_out(Reduction& r, Superelement& s) {
  if (r.options.fixed.empty()) return;
  require_one_part(r, "fixed");
  const Matrix R = rigid_modes(r.x, s.rigid_body.center), momentum = r.model.M * R;
  fix_dofs(r.mesh, r.options.fixed, r.model);
  std::vector<Index> fixed, free;
  for (Index dof = 0; dof < R.rows(); ++dof) (r.model.is_fixed(dof) ? fixed : free).push_back(dof);
  r.momentum = momentum(free, Eigen::all);
  const RightSingular moved =
      right_singular(R(fixed, Eigen::all) * rigid_scales(s.rigid_body).asDiagonal());
  const Index n = (moved.values.array() > moves_none * moved.values(0)).count();
  s.fixed.resisted = moved.V.leftCols(n).transpose();
}

// Of a reduced interface those nodes that keep all of their dofs, ascending. kept: of the interface
std::vector<Index> whole_nodes(const Reduction& r, const std::vector<Index>& kept) {
  const CharacteristicOptions& options = r.options.characteristic;
  std::vector<Index> whole;
  for (const auto* names : {&options.keep, &options.needs.held})
    for (const std::string& name : *names) {
      if (find_sideset(r.mesh, name) < 0 && find_nodeset(r.mesh, name) < 0) continue;
      std::vector<Index> nodes;
      for (const Index node : set_nodes(r.mesh, name)) nodes.push_back(r.model.row[node]);
      std::sort(nodes.begin(), nodes.end());
      if (std::includes(kept.begin(), kept.end(), nodes.begin(), nodes.end()))
        whole.insert(whole.end(), nodes.begin(), nodes.end());
    }
  sort_uniquely(whole);
  return whole;
}

// Rotations of kept nodes are kept too, but for those that are to be condensed, and those of nodes
// whose displacements are reduced. kept: ascending
void keep_rotations(const Reduction& r, std::vector<Index>& kept) {
  if (r.options.has_hinges()) return;
  const std::vector<Index> nodes = r.options.is_characteristic() ? whole_nodes(r, kept) : kept;
  for (Index i = r.model.n_translations(); i < static_cast<Index>(r.model.nodes.size()); ++i)
    if (std::binary_search(nodes.begin(), nodes.end(), r.model.row[mesh_node(r, i)]))
      kept.push_back(i);
}

// Model nodes of the options' sets, and those of points.
std::vector<Index> kept_nodes(const Reduction& r) {
  std::vector<Index> kept = nodes_of_sets(r.mesh, r.model, r.options);
  const auto n = static_cast<Index>(r.model.nodes.size());
  for (Index i = n - 2 * r.p.n_points; i < n; ++i) kept.push_back(i);
  return kept;
}

// Judges K_II by its factor. InputError: it is singular.
void judge_interior(Reduction& r, const SparseCholesky& factor) {
  return_room();
  if (r.p.n_interior() == 0) return;
  if (!factor.ok() || factor.smallest_pivot() < singular_pivot) {
    throw InputError("the stiffness of the interior is singular at " +
                     node_of_interior_dof(r, factor.weakest_column()) +
                     ": a part of it can move freely, as elements do that share only an edge or a "
                     "node with the rest, or is held too weakly for a double, as very thin parts "
                     "are and what an interface nearly on one line holds; correct the mesh there "
                     "or put nodes of that part into the interface" +
                     (r.model.n_rotations > 0
                          ? "; the edge of a shell on solids is a hinge, unless the shell goes on "
                            "along their faces"
                          : ""));
  }
  Conditioning& condition = r.figures.condition;
  condition.smallest_pivot = factor.smallest_pivot();
  condition.weakest = node_of_interior_dof(r, factor.weakest_column());
  condition.K_II = condition_numbers(r.p.K_II, factor);
  r.figures.factor_nonzeros = factor.n_nonzeros();
  r.figures.factor_flops = factor.flops();
}

CondensationOptions condensation_options(const Reduction& r, const Matrix& Phi) {
  CondensationOptions options;
  options.memory = panel_memory(r.settings.memory, r.p, *r.factor, Phi);
  options.way = r.settings.way;
  options.panel = r.settings.panel;
  options.keep_Psi = r.options.recovery;
  options.one_Psi = needs_one_Psi(r.figures.condition.K_II.scaled);
  return options;
}

// Where no later step reads them.
void drop_model(Reduction& r) {
  r.model.K = SparseMatrix();
  r.model.M = SparseMatrix();
}

}  // namespace

void return_room() { return_unused_heap(0.1 * machine_memory_bytes()); }

bool may_condense_by_fronts(const Reduction& r) {
  const bool asked = r.settings.way == CondensationWay::fronts;
  return !r.options.recovery && r.options.fixed.empty() &&
         (asked || r.settings.way == CondensationWay::automatic) && r.settings.panel == 0;
}

void take_factor(Reduction& r, SparseCholesky&& factor) {
  r.factor = std::move(factor);
  r.inside = std::make_unique<LocalInterior>(r.p, *r.factor);
}

void factorise_interior(Reduction& r) {
  const auto phase = r.report.phase("factorisation");
  SparseCholesky factor(r.p.K_II, {},
                        [&](double share) { r.report.progress("factorisation", share); });
  judge_interior(r, factor);
  take_factor(r, std::move(factor));
}

FreeFactor factorise_free(Reduction& r, const FreeComponent& model, Index n_forces) {
  const auto phase = r.report.phase("factorisation");
  FreeFactor free = free_factor(model, r.p, n_forces,
                                [&](double share) { r.report.progress("factorisation", share); });
  if (free.interior) judge_interior(r, *free.interior);
  return free;
}

void LocalEngine::assemble(Reduction& r, Superelement& s) {
  const auto phase = r.report.phase("assembly");
  take(cbr::assemble(r.mesh, r.properties, r.mass), r.model);
  std::vector<Index> kept;
  r.part = connected_parts(r.mesh, r.model);
  if (!r.settings.is_domain) tell_of_parts(r.mesh, r.model, r.part, r.report);
  r.x = r.mesh.coordinates(r.model.nodes, Eigen::all);
  s.rigid_body = rigid_body(r.model.M, r.x, r.model.n_rotations);
  check_rigid_motions(r, s.rigid_body.center);
  r.figures.n_dofs = r.model.K.rows();
  r.figures.mesh_nonzeros = static_cast<double>(r.model.K.nonZeros());
  take_points_in(r);
  take_fixed_out(r, s);
  if (interface_ == nullptr) {
    kept = kept_nodes(r);
  } else {
    for (const Index node : *interface_) kept.push_back(r.model.row[node]);
  }
  if (r.model.n_rotations > 0) keep_rotations(r, kept);
  if (!r.options.is_characteristic())
    require_memory_for_interface(3 * static_cast<Index>(kept.size()), machine_memory_bytes());
  partition(r.model, kept, r.p);
  if (r.p.n_interface() == 0 && r.p.has_fixed())
    throw InputError(r.options.fixed.front().source.text() +
                     ": reduction.fixed leaves no dof of the interface (" +
                     join(r.options.interface_sets) + "): fix fewer axes, or keep other sets");
  r.figures.n_interior = r.p.n_interior();
  if (!r.options.is_massless() && !r.options.is_characteristic() && !may_condense_by_fronts(r))
    drop_model(r);
  check_interface_holds(r.mesh, r.model, r.p, r.part);
}

void LocalEngine::factorise(Reduction& r) {
  const bool drops = !r.options.is_massless();
  if (may_condense_by_fronts(r)) {
    const auto phase = r.report.phase("factorisation and condensation");
    Condensed condensed;
    std::optional<SparseCholesky> factor = SparseCholesky::condensing(
        r.model.K, r.model.M, r.p.interface_rows, condensed,
        r.settings.way == CondensationWay::fronts,
        [&](double share) { r.report.progress("factorisation and condensation", share); });
    if (factor) {
      if (drops) drop_model(r);
      judge_interior(r, *factor);
      take_factor(r, std::move(*factor));
      by_fronts_ = std::move(condensed);
      return;
    }
  }
  if (drops) drop_model(r);
  factorise_interior(r);
}

Index LocalEngine::count_below(Reduction& r, double hz) {
  return count_modes_below(r.p, *r.factor, hz, r.report);
}

FixedInterfaceModes LocalEngine::lowest_modes(Reduction& r, Index k) {
  const Index n_I = r.p.n_interior();
  // Residual vectors of loads are K-orthogonal to eigenvectors alone
  const bool is_exact = r.options.exact_modes || !r.options.loads.empty();
  FixedInterfaceModes modes = has_parts(r) && k <= n_I
                                  ? fixed_interface_modes_by_part(parts(r), n_I, k, r.report)
                                  : fixed_interface_modes(r.p, *r.factor, k, r.report,
                                                          is_exact ? to_round_off : basis_residual);
  r.report.end_progress();
  return_room();
  return modes;
}

Condensation LocalEngine::condense(Reduction& r, const Matrix& Phi) {
  const CondensationOptions options = condensation_options(r, Phi);
  const auto &inside = r.p.interior_nodes, &on_interface = r.p.interface_nodes;
  r.p.rigid = rigid_motions(r.p, coordinates_of(r, inside), parts_of_nodes(r, inside), 0,
                            coordinates_of(r, on_interface), parts_of_nodes(r, on_interface));
  // Of an ill-conditioned K_II all comes from one Psi
  Condensation condensed = by_fronts_ && !options.one_Psi
                               ? complete(r.p, *r.factor, Phi, std::move(*by_fronts_))
                               : cbr::condense(r.p, *r.factor, Phi, options, r.report);
  by_fronts_.reset();
  // One point alone: all that it does moves the part as a rigid body, and K_cc is round-off
  if (r.p.rigid.count() == r.p.n_interface()) {
    condensed.K_cc.setZero();
    condensed.rigid.force = 0;
  }
  return condensed;
}

void couple_again(Reduction& r, const Matrix& Phi, Condensation& condensed) {
  const auto phase = r.report.phase("condensation");
  CondensationOptions options = condensation_options(r, Phi);
  options.panel = r.figures.panel;  // of which round-off depends
  condensed.M_kc = mode_coupling_of_one_Psi(r.p, *r.factor, Phi, options, r.report);
}

Matrix constraint_modes(const Reduction& r) {
  Matrix Psi = -Matrix(r.p.K_IC);
  r.inside->solve_in_place(Psi);
  return Psi;
}

}  // namespace cbr
