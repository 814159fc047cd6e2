// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/reduce.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/machine_memory.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/linalg/huge_pages.hpp"
#include "common/scene/scene_words.hpp"
#include "reducer/bases/free_shapes.hpp"
#include "reducer/bases/reduction_steps.hpp"
#include "reducer/condensation/panel_memory.hpp"
#include "reducer/condensation/residual_mass.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/judgement/mode_tolerance.hpp"
#include "reducer/modes/diagonal_form.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"
#include "reducer/modes/interior_loads.hpp"
#include "reducer/modes/spin_moments.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
namespace {

constexpr double singular_pivot = 1e-14;

bool has_free_modes(const ReductionOptions& options) {
  return options.is_massless() && options.massless_modes != MasslessModes::fixed;
}

// Fronts, or a Lanczos basis, have left room in the heap that may be needed as one piece elsewhere.
void return_room() { return_unused_heap(0.1 * machine_memory_bytes()); }

// What the factor of K_II says of it. InputError: it is singular.
void judge_interior(Reduction& r, const SparseCholesky& factor) {
  return_room();
  if (r.p.n_interior() == 0) return;
  if (!factor.ok() || factor.smallest_pivot() < singular_pivot) {
    throw InputError("the stiffness of the interior is singular at " +
                     node_of_interior_dof(r, factor.weakest_column()) +
                     ": a part of it can move freely, as elements do that share only an edge or a "
                     "node with the rest, or is held "
                     "too weakly for a double, as very thin parts are and what an interface nearly "
                     "on one line holds; correct the mesh "
                     "there or put nodes of that part into the interface" +
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

SparseCholesky factorise(Reduction& r) {
  const auto phase = r.report.phase("factorisation");
  SparseCholesky factor(r.p.K_II, {},
                        [&](double share) { r.report.progress("factorisation", share); });
  judge_interior(r, factor);
  return factor;
}

// Whether the condensation may come with the factorisation: nothing reads Psi, nobody asks for a
// way.
bool may_condense_by_fronts(const Reduction& r) {
  const bool asked = r.settings.way == CondensationWay::fronts;
  return !r.options.recovery && (asked || r.settings.way == CondensationWay::automatic) &&
         r.settings.panel == 0;
}

struct FactorAndCondensed {
  SparseCholesky factor;
  std::optional<Condensed> condensed;
};

FactorAndCondensed factorise_and_condense(Reduction& r) {
  if (may_condense_by_fronts(r)) {
    const auto phase = r.report.phase("factorisation and condensation");
    Condensed condensed;
    std::optional<SparseCholesky> factor = SparseCholesky::condensing(
        r.model.K, r.model.M, dofs_of(r.p.interface_nodes), condensed,
        r.settings.way == CondensationWay::fronts,
        [&](double share) { r.report.progress("factorisation and condensation", share); });
    if (factor) {
      if (!has_free_modes(r.options)) r.model.K = SparseMatrix(), r.model.M = SparseMatrix();
      judge_interior(r, *factor);
      return {std::move(*factor), std::move(condensed)};
    }
  }
  if (!has_free_modes(r.options)) r.model.K = SparseMatrix(), r.model.M = SparseMatrix();
  return {factorise(r), {}};
}

Index n_modes_wanted(const Reduction& r, const SparseCholesky& factor) {
  check_modes_wanted(r.options);
  if (r.options.modes) return *r.options.modes;
  const auto phase = r.report.phase("modes: count below cutoff");
  return count_modes_below(r.p, factor, *r.options.cutoff_hz);
}

void check_found(Reduction& r, const FixedInterfaceModes& modes) {
  r.figures.mode_method = modes.method;
  r.figures.modes_proven = modes.proven;
  r.figures.condition.counts = modes.counts;
  const auto check = [&](const Vector& lambda, const Matrix& Phi) {
    r.figures.condition.modes = check_modes(r.p, lambda, Phi);
    require_independent(r.p, Phi, r.figures.condition.modes);
  };
  if (modes.picked.empty()) return check(modes.lambda, modes.Phi);
  check(modes.lambda(modes.picked), modes.Phi(Eigen::all, modes.picked));
}

FixedInterfaceModes modes_to_compute(Reduction& r, const SparseCholesky& factor) {
  const Index wanted = n_modes_wanted(r, factor), n_I = r.p.n_interior();
  if (r.options.pick == Pick::participation && !r.options.modes)
    throw InputError("pick: participation needs `modes`: a cutoff keeps every mode below it");
  const Index candidates = n_mode_candidates(r.options.pick, wanted, n_I),
              picked = candidates > wanted ? wanted : 0;
  const auto phase = r.report.phase("fixed-interface modes");
  r.report.progress("fixed-interface modes", 0);
  FixedInterfaceModes modes =
      has_parts(r) && candidates <= n_I
          ? fixed_interface_modes_by_part(parts(r), n_I, candidates, r.report)
          : fixed_interface_modes(r.p, factor, candidates, r.report, picked);
  r.report.end_progress();
  return_room();
  if (r.options.cutoff_hz && wanted > 0) {
    const double cutoff = 2 * std::numbers::pi * *r.options.cutoff_hz;
    if (modes.lambda(wanted - 1) > cutoff * cutoff * (1 + 1e-9)) {
      throw RunError(
          "the eigensolver found fewer modes below the cutoff than the inertia count says: choose "
          "another cutoff");
    }
  }
  r.figures.n_candidates = candidates;
  check_found(r, modes);
  if (r.options.modes && r.options.pick == Pick::frequency)
    warn_of_cut_pair(modes.lambda, modes.next, r.report);
  return modes;
}

void keep_modes(Reduction& r, FixedInterfaceModes& modes, Condensation& condensed) {
  r.not_kept.Phi.resize(r.p.n_interior(), 0);
  if (modes.lambda.size() > 0)
    r.not_kept.beyond = std::max(modes.next, modes.lambda(modes.lambda.size() - 1));
  if (r.options.pick != Pick::participation || modes.lambda.size() <= *r.options.modes) return;
  const std::vector<Index> kept = modes.picked.empty()
                                      ? modes_by_participation(condensed.M_kc, *r.options.modes)
                                      : modes.picked;
  std::vector<Index> others;
  for (Index j = 0; j < modes.lambda.size(); ++j)
    if (!std::binary_search(kept.begin(), kept.end(), j)) others.push_back(j);
  r.not_kept.lambda = modes.lambda(others), r.not_kept.Phi = modes.Phi(Eigen::all, others);
  modes.lambda = Vector(modes.lambda(kept));
  modes.Phi = Matrix(modes.Phi(Eigen::all, kept));
  condensed.M_kc = Matrix(condensed.M_kc(kept, Eigen::all));
}

void pick_by_tolerance(Reduction& r, const SparseCholesky& factor, const InterfaceMotions& motions,
                       const Superelement& s, FixedInterfaceModes& modes, Condensation& condensed) {
  const auto phase = r.report.phase("fixed-interface modes");
  ModesOfTolerance found = [&] {
    try {
      return has_parts(r) ? modes_of_tolerance(r.p, parts(r), s, *r.options.tolerance, r.report)
                          : modes_of_tolerance(r.p, factor, motions, s, parts_of_interface(r),
                                               *r.options.tolerance, r.report);
    } catch (const LostMass& lost) {
      throw InputError(lost.what() + ("; first at " + r.figures.condition.weakest));
    }
  }();
  r.figures.n_candidates = found.n_candidates;
  r.not_kept = std::move(found.not_kept);
  modes = std::move(found.modes);
  check_found(r, modes);
  condensed.M_kc = mode_coupling(r.p, factor, modes.Phi, s.M_cc);
}

void keep_figures(Reduction& r, const Superelement& s, MasslessFigures&& m) {
  r.figures.highest_frequency = std::sqrt(s.eigenvalues.maxCoeff()) / (2 * std::numbers::pi);
  r.figures.massless = std::move(m);
}

void refuse_mechanism(Reduction& r, const Superelement& s) {
  const Matrix R = rigid_motions_of_parts(s, parts_of_interface(r)).bottomRows(s.c());
  const SoftestMotion softest = softest_motion(s.K_cc, R);
  r.figures.condition.softest = softest.stiffness;
  if (s.c() == R.cols()) return;
  refuse_mechanism(softest, softest.dof >= 0 ? node_of_interface_dof(r, softest.dof)
                                             : r.figures.condition.weakest);
}

// Basis massless, of the free modes; K_cc and M_cc of a condensation without modes.
void make_free(Reduction& r, const SparseCholesky& factor, Condensation& condensed,
               Superelement& s) {
  const auto phase = r.report.phase("free modes");
  s.K_cc = std::move(condensed.K_cc), s.M_cc = std::move(condensed.M_cc);
  refuse_mechanism(r, s);
  MasslessFigures m =
      make_massless_free({r.model.K, r.model.M, r.x, r.part}, r.p, factor,
                         {r.options.modes.value_or(0), r.options.cutoff_hz.value_or(0),
                          r.options.massless_modes == MasslessModes::tapered},
                         s, r.report);
  r.figures.n_candidates = s.k();
  r.figures.mode_method = m.method, r.figures.modes_proven = m.proven;
  r.figures.condition.counts = m.counts, r.figures.condition.modes = m.modes;
  if (r.options.modes) warn_of_cut_pair(s.eigenvalues, m.next, r.report);
  s.accuracy = accuracy_of_free_modes(s.eigenvalues.tail(s.k() - m.n_rigid), m.next, m.share);
  keep_figures(r, s, std::move(m));
}

void make_fixed(Reduction& r, Superelement& s) {
  const auto phase = r.report.phase("massless form");
  refuse_mechanism(r, s);
  keep_figures(r, s, make_massless_fixed(parts_of_interface(r), s));
}

// Returns residual_mass_factor().
Cholesky add_diagonal(Reduction& r, Superelement& s) {
  const auto phase = r.report.phase("diagonal form");
  const std::vector<Index> part = parts_of_interface(r);
  Cholesky M_res = residual_mass_factor(s);
  if (s.n() <= r.settings.diagonal_limit) {
    r.figures.condition.n_rigid = r.settings.is_diagonal_read
                                      ? add_diagonal_form(s, part, &M_res)
                                      : add_lowest_modes(s, part, n_estimated + n_beside);
  }
  const Index loose =
      examine_reduced(s, rigid_motions_of_parts(s, part), M_res, r.figures.condition);
  if (loose >= 0) r.figures.condition.loose_node = node_of_interface_dof(r, loose);
  return M_res;
}

void make_shapes(Reduction& r, const SparseCholesky& factor, Superelement& s) {
  const auto phase = r.report.phase("characteristic modes");
  const std::vector<Index> part = parts_of_interface(r);
  r.figures.characteristic =
      make_characteristic(r.options.characteristic, part, interior_inertia(r.p.rigid, factor), s);
  const Index loose =
      examine_characteristic(s, r.figures.characteristic, part, r.figures.condition);
  if (loose >= 0) r.figures.condition.loose_node = node_of_interface_dof(r, loose);
}

// Modes that are known before the condensation.
FixedInterfaceModes first_modes(Reduction& r, const SparseCholesky& factor) {
  if (!has_free_modes(r.options) && !r.options.tolerance) return modes_to_compute(r, factor);
  check_modes_wanted(r.options);
  FixedInterfaceModes none;
  none.Phi.resize(r.p.n_interior(), 0);
  return none;
}

CondensationOptions condensation_options(const Reduction& r, const SparseCholesky& factor,
                                         const Matrix& Phi) {
  CondensationOptions options;
  options.memory = panel_memory(r.settings.memory, r.p, factor, Phi);
  options.way = r.settings.way;
  options.panel = r.settings.panel;
  options.keep_Psi = r.options.recovery;
  options.one_Psi = needs_one_Psi(r.figures.condition.K_II.scaled);
  return options;
}

// M_kc by the Psi that K_cc and M_cc are made with, of modes that were not known then.
void couple_again(Reduction& r, const SparseCholesky& factor, const Matrix& Phi, const Matrix& M_cc,
                  Condensation& condensed) {
  const auto phase = r.report.phase("condensation");
  CondensationOptions options = condensation_options(r, factor, Phi);
  options.panel = r.figures.panel;  // of which round-off depends
  condensed.M_kc = mode_coupling_of_one_Psi(r.p, factor, Phi, M_cc, options, r.report);
}

Condensation condense_with(Reduction& r, const SparseCholesky& factor, const Matrix& Phi,
                           std::optional<Condensed>&& condensed_by_fronts) {
  const CondensationOptions options = condensation_options(r, factor, Phi);
  const auto phase = r.report.phase("condensation");
  const auto &inside = r.p.interior_nodes, &on_interface = r.p.interface_nodes;
  r.p.rigid = rigid_motions(r.p, coordinates_of(r, inside), parts_of_nodes(r, inside), 0,
                            coordinates_of(r, on_interface), parts_of_nodes(r, on_interface));
  // Of an ill-conditioned K_II all comes from one Psi
  Condensation condensed = condensed_by_fronts && !options.one_Psi
                               ? complete(r.p, factor, Phi, std::move(*condensed_by_fronts))
                               : condense(r.p, factor, Phi, options, r.report);
  r.figures.solve_flops = condensed.solve_flops;
  r.figures.product_flops = condensed.product_flops;
  r.figures.front_flops = condensed.front_flops;
  r.figures.way = condensed.way;
  r.figures.panel = condensed.panel;
  return condensed;
}

// Residual vectors of the loads inside, after the modes; and what the loads do to the coordinates.
void add_loads(Reduction& r, const SparseCholesky& factor, FixedInterfaceModes& modes,
               Condensation& condensed, Superelement& s) {
  const InteriorLoads loads = interior_loads(r.mesh, r.model, r.p, r.options.loads);
  if (!loads.any()) return;
  const auto phase = r.report.phase("residual vectors");
  s.n_residual = has_parts(r) ? add_residual_vectors(parts(r), loads.F_I, modes)
                              : add_residual_vectors(r.p, factor, loads.F_I, modes);
  const Matrix more = mode_coupling(r.p, factor, modes.Phi.rightCols(s.n_residual), s.M_cc);
  condensed.M_kc.conservativeResize(modes.lambda.size(), r.p.n_interface());
  condensed.M_kc.bottomRows(s.n_residual) = more;
  s.loads = generalised_loads(r.p, factor, loads, modes.Phi, s.M_cc);
}

// Of what can turn by itself.
void add_spin_moments(const Reduction& r, const SparseCholesky& factor, const Matrix& Phi,
                      Superelement& s) {
  if (r.settings.is_domain || has_parts(r) || r.p.n_points > 0) return;
  s.spin_moments =
      spin_moments(r.p, factor, coordinates_of(r, r.p.interior_nodes),
                   coordinates_of(r, r.p.interface_nodes), s.rigid_body.center, Phi, s.M_cc);
}

void take_matrices(Reduction& r, FixedInterfaceModes& modes, Condensation& condensed,
                   Superelement& s) {
  s.eigenvalues = modes.lambda;
  s.M_kc = std::move(condensed.M_kc);
  const Index own = s.k() - s.n_residual;
  if (own > 0)
    r.figures.highest_frequency =
        std::sqrt(s.eigenvalues.head(own).maxCoeff()) / (2 * std::numbers::pi);
}

void add_accuracy(Reduction& r, const SparseCholesky& factor, const InterfaceMotions& motions,
                  const Matrix& Phi, const Cholesky& M_res, Superelement& s) {
  const auto phase = r.report.phase("errors");
  FreeEigenvalues free;
  s.accuracy = accuracy_of(r.p, factor, motions, s, Phi, r.figures.condition.n_rigid, r.not_kept,
                           parts(r), true, &free, &M_res);
  if (r.options.tolerance)
    judge_tolerance(*r.options.tolerance, s.accuracy->largest_left_out, free.worst_of_ten,
                    r.figures.condition.K_II.scaled, r.report);
  s.accuracy->tolerance = r.options.tolerance.value_or(0);
}

// Of Craig-Bampton's form, from which s is to go over to another basis: what is known of it, and
// its lowest free modes.
FreeEigenvalues look_before(Reduction& r, const SparseCholesky& factor, const Matrix& Phi,
                            Superelement& s) {
  const auto phase = r.report.phase("errors");
  FreeEigenvalues free;
  const std::vector<Index> part = parts_of_interface(r);
  const InterfaceMotions motions = interface_motions(r.p, factor, s, part, false);
  Index n_rigid = 0;
  try {
    if (s.n() <= r.settings.diagonal_limit)
      n_rigid = add_lowest_modes(s, part, n_estimated + n_beside);
  } catch (const InputError&) {
    s.omega.resize(0);  // a mass of round-off, with which the other basis may get on
  }
  s.accuracy =
      accuracy_of(r.p, factor, motions, s, Phi, n_rigid, r.not_kept, parts(r), false, &free);
  s.omega.resize(0), s.V.resize(0, 0);
  return free;
}

// And of the basis that it became, whose elastic eigenvalues come after the rigid ones.
void look_after(const FreeEigenvalues& free, Index n_rigid, Superelement& s) {
  judge_eigenvalues(s.eigenvalues.tail(s.k() - n_rigid), free, *s.accuracy);
}

// Accelerations of the interface as a rigid body, and what they ask of the interior; no matrices of
// the interface are needed.
InterfaceMotions rigid_accelerations(const Reduction& r, const SparseCholesky& factor,
                                     const Superelement& s) {
  InterfaceMotions motions;
  const Vector3& center = s.rigid_body.center;
  const Matrix R_I = rigid_modes(coordinates_of(r, r.p.interior_nodes), center);
  motions.W = rigid_modes(s.coordinates, center);
  motions.Y = r.p.M_II * R_I + r.p.M_IC * motions.W;
  motions.E = motions.Y.transpose() * factor.solve(motions.Y);
  motions.E = (0.5 * (motions.E + motions.E.transpose())).eval();
  return motions;
}

// rho_res: of the mass of a translation what the fixed-interface modes do not have; they have Phi^T
// (M t)_I of it.
Vector3 residual_mass_share(const InterfaceMotions& rigid, const Matrix& Phi, double mass) {
  const Matrix taken = Phi.transpose() * rigid.Y.leftCols(3);
  return Vector3::Ones() - taken.colwise().squaredNorm().transpose() / mass;
}

// What the fixed-interface modes leave out, and by how much the lowest frequencies are off: those
// of the full component are known.
void add_accuracy_of_shapes(Reduction& r, const SparseCholesky& factor,
                            const FixedInterfaceModes& modes, const Vector& free, Superelement& s) {
  const auto phase = r.report.phase("errors");
  const InterfaceMotions rigid = rigid_accelerations(r, factor, s);
  Superelement held;
  held.eigenvalues = modes.lambda, held.rigid_body = s.rigid_body;
  held.dof_node = s.dof_node, held.dof_component = s.dof_component;
  s.accuracy = accuracy_of_fixed_modes(r.p, factor, rigid, held, modes.Phi,
                                       settled(r.not_kept, r.p, factor, held));
  s.accuracy->rho_res = r.figures.characteristic.rho =
      residual_mass_share(rigid, modes.Phi, s.rigid_body.mass);
  const Vector lambda = s.eigenvalues.tail(s.k() - r.figures.characteristic.n_rigid);
  const Index n = std::min({lambda.size(), free.size(), n_estimated});
  FreeEigenvalues known{lambda.head(n), free.head(n).cwiseMin(lambda.head(n))};
  judge_eigenvalues(lambda, known, *s.accuracy);
}

// Psi of the interior, column by column   (n_I x c)
Matrix constraint_modes(const Reduction& r, const SparseCholesky& factor) {
  Matrix Psi = -Matrix(r.p.K_IC);
  factor.solve_in_place(Psi);
  return Psi;
}

FreeFactor factorise_free(Reduction& r, const FreeComponent& model, Index n_forces) {
  const auto phase = r.report.phase("factorisation");
  FreeFactor free = free_factor(model, r.p, n_forces,
                                [&](double share) { r.report.progress("factorisation", share); });
  if (free.interior) judge_interior(r, *free.interior);
  return free;
}

// Basis characteristic by sparse solves alone: of one factor, or of two, one after the other.
// False: it is for the way by dense matrices.
bool reduce_to_free_shapes(Reduction& r, Superelement& s) {
  const CharacteristicOptions& options = r.options.characteristic;
  if (!few_enough(options, !has_parts(r), r.p.n_interior(), s)) return false;
  std::optional<FreeShapes> shapes;
  s.characteristic.statics = static_forces(options, s);
  const FreeComponent model{r.model.K, r.model.M, r.x};
  std::optional<FreeFactor> free = factorise_free(r, model, s.characteristic.statics.size());
  {
    const auto phase = r.report.phase("shapes and statics");
    shapes = free_shapes(options, model, *free, r.p, s.characteristic.statics, s, r.report);
  }
  if (!shapes) return false;
  r.model.K = SparseMatrix(), r.model.M = SparseMatrix();
  std::optional<SparseCholesky> own = std::move(free->interior);
  free.reset();
  if (!own) own = factorise(r);
  const SparseCholesky& factor = *own;
  follow_statically(r.p, factor, *shapes);
  FixedInterfaceModes modes = first_modes(r, factor);
  r.p.K_II = SparseMatrix(r.p.n_interior(), r.p.n_interior());
  Condensation coupled;
  coupled.M_kc = coupling_of_eigenvectors(r.p, modes.lambda, modes.Phi);
  keep_modes(r, modes, coupled);
  if (modes.lambda.size() > 0)
    r.figures.highest_frequency = std::sqrt(modes.lambda.maxCoeff()) / (2 * std::numbers::pi);
  Matrix interior;
  {
    const auto phase = r.report.phase("characteristic modes");
    r.figures.characteristic = take_free_shapes(*shapes, modes.lambda, modes.Phi, r.p, s,
                                                r.options.recovery ? &interior : nullptr);
    const std::vector<Index> part = parts_of_interface(r);
    const Index loose =
        examine_characteristic(s, r.figures.characteristic, part, r.figures.condition);
    if (loose >= 0) r.figures.condition.loose_node = node_of_interface_dof(r, loose);
  }
  add_accuracy_of_shapes(r, factor, modes, shapes->lambda, s);
  if (!r.options.recovery) return true;
  const auto phase = r.report.phase("recovery");
  // u_I = Psi u_c + Phi q, of which the coordinates' own motion of the interface is in Psi u_c
  Matrix Psi = constraint_modes(r, factor);
  interior.noalias() -= Psi * s.characteristic.V;
  add_recovery(r, std::move(Psi), std::move(interior), s);
  return true;
}

void condense_and_keep(Reduction& r, Superelement& s) {
  if (r.options.is_characteristic() && reduce_to_free_shapes(r, s)) return;
  require_memory_for_interface(r.p.n_interface(), machine_memory_bytes());
  FactorAndCondensed first = factorise_and_condense(r);
  const SparseCholesky factor = std::move(first.factor);
  FixedInterfaceModes modes = first_modes(r, factor);
  // From here on only its factor is needed, and the space may be; an inertia count of modes to come
  // takes K_II itself, and so do parts
  if (!r.options.tolerance && !has_parts(r))
    r.p.K_II = SparseMatrix(r.p.n_interior(), r.p.n_interior());
  Condensation condensed = condense_with(r, factor, modes.Phi, std::move(first.condensed));
  // One point alone: all that it does moves the part as a rigid body, and K_cc is round-off
  if (r.p.rigid.count() == r.p.n_interface()) condensed.K_cc.setZero(), condensed.rigid.force = 0;
  r.figures.rigid = condensed.rigid;
  if (r.p.rigid.count() > 0)
    judge_rigid(condensed.rigid, r.figures.condition.K_II.scaled, r.figures.condition.weakest,
                r.report);
  if (has_free_modes(r.options)) return make_free(r, factor, condensed, s);
  keep_modes(r, modes, condensed);
  s.K_cc = std::move(condensed.K_cc);
  s.M_cc = std::move(condensed.M_cc);
  if (r.options.is_massless()) {
    take_matrices(r, modes, condensed, s);
    const FreeEigenvalues free = look_before(r, factor, modes.Phi, s);
    make_fixed(r, s);
    return look_after(free, r.figures.massless.n_rigid, s);
  }
  InterfaceMotions motions;
  // whose errors are told
  const bool judged = !r.options.is_characteristic() && !r.settings.is_domain;
  if (judged || (r.options.tolerance && !has_parts(r))) {
    const auto phase = r.report.phase("errors");
    motions = interface_motions(r.p, factor, s, parts_of_interface(r));
  }
  if (r.options.tolerance) {
    pick_by_tolerance(r, factor, motions, s, modes, condensed);
    if (needs_one_Psi(r.figures.condition.K_II.scaled))
      couple_again(r, factor, modes.Phi, s.M_cc, condensed);
  }
  if (!r.options.loads.empty()) add_loads(r, factor, modes, condensed, s);
  take_matrices(r, modes, condensed, s);
  if (!r.options.is_characteristic()) add_spin_moments(r, factor, modes.Phi, s);
  r.figures.condition.reduced_rigid =
      rigid_residual(s.K_cc, reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c())).value;
  if (judged) {
    const Cholesky M_res = add_diagonal(r, s);
    add_accuracy(r, factor, motions, modes.Phi, M_res, s);
  }
  if (!r.settings.is_diagonal_read) s.omega.resize(0), s.V.resize(0, 0);
  FreeEigenvalues free;
  if (r.options.is_characteristic()) free = look_before(r, factor, modes.Phi, s);
  if (r.options.recovery) add_recovery(r, std::move(condensed.Psi), std::move(modes.Phi), s);
  if (!r.options.is_characteristic()) return;
  make_shapes(r, factor, s);
  look_after(free, r.figures.condition.n_rigid, s);
  const Vector lambda = s.eigenvalues.tail(s.k() - r.figures.condition.n_rigid);
  const Index ten = std::min({lambda.size(), free.with_basis.size(), n_free_modes_of_tolerance});
  if (ten > 0)
    r.figures.shapes_error =
        (1 - free.with_basis.head(ten).array() / lambda.head(ten).array()).maxCoeff();
}

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
  model.K.swap(made.K), model.M.swap(made.M);
  model.nodes = std::move(made.nodes), model.row = std::move(made.row);
  model.n_rotations = made.n_rotations;
}

// From here on the model has the points in the place of their sets' nodes.
void take_points_in(Reduction& r) {
  if (r.settings.points.empty()) return;
  if (has_parts(r))
    throw InputError(r.options.source.text() +
                     ": reduction.points: the component has several parts, which nothing joins, "
                     "and points need one: give each part a component of its own");
  if (r.model.n_rotations > 0)
    throw InputError(r.options.source.text() +
                     ": reduction.points does not know shells (blocks.NAME.thickness), whose nodes "
                     "have rotations of their own: name their sets in reduction.interface, which "
                     "keeps these");
  couple_rigidly(r.mesh, r.settings.points, r.model, r.x);
  r.p.n_points = static_cast<Index>(r.settings.points.size());
  r.part.assign(r.model.nodes.size(), 0);
}

// Rotations of kept nodes are kept too, unless they are to be condensed. kept: ascending
void keep_rotations(const Reduction& r, std::vector<Index>& kept) {
  if (r.options.condenses_rotations) return;
  const std::vector<Index> nodes = kept;
  for (Index i = r.model.n_translations(); i < static_cast<Index>(r.model.nodes.size()); ++i)
    if (std::binary_search(nodes.begin(), nodes.end(),
                           r.model.row[static_cast<std::size_t>(mesh_node(r, i))]))
      kept.push_back(i);
}

// Model nodes of the options' sets, and those of points.
std::vector<Index> kept_nodes(const Reduction& r) {
  std::vector<Index> kept = nodes_of_sets(r.mesh, r.model, r.options);
  const auto n = static_cast<Index>(r.model.nodes.size());
  for (Index i = n - 2 * r.p.n_points; i < n; ++i) kept.push_back(i);
  return kept;
}

// `interface`: mesh nodes, or none: those of the options' sets.
Superelement reduce_to(const std::vector<Index>* interface, const Mesh& mesh,
                       const std::vector<BlockProperties>& properties, MassKind mass,
                       const ReductionOptions& options, const ReduceSettings& settings,
                       Report& report, ReductionFigures* figures) {
  Reduction r{mesh, options, settings, report, {}, {}, {}, {}, {}, {}};
  Superelement s;
  {
    const auto phase = report.phase("assembly");
    take(assemble(mesh, properties, mass), r.model);
    std::vector<Index> kept;
    r.part = connected_parts(mesh, r.model);
    if (!settings.is_domain) tell_of_parts(mesh, r.model, r.part, report);
    r.x = mesh.coordinates(r.model.nodes, Eigen::all);
    s.rigid_body = rigid_body(r.model.M, r.x, r.model.n_rotations);
    check_rigid_motions(r, s.rigid_body.center);
    r.figures.n_dofs = r.model.K.rows();
    take_points_in(r);
    if (interface == nullptr) {
      kept = kept_nodes(r);
    } else {
      for (const Index node : *interface)
        kept.push_back(r.model.row[static_cast<std::size_t>(node)]);
    }
    if (r.model.n_rotations > 0) keep_rotations(r, kept);
    if (!options.is_characteristic())
      require_memory_for_interface(3 * static_cast<Index>(kept.size()), machine_memory_bytes());
    partition(r.model, kept, r.p);
    r.figures.n_interior = r.p.n_interior();
    if (!has_free_modes(options) && !options.is_characteristic() && !may_condense_by_fronts(r))
      r.model.K = SparseMatrix(), r.model.M = SparseMatrix();
  }
  check_interface_holds(mesh, r.model, r.p, r.part);
  describe_interface(r, s);
  s.basis = word_of(basis_words, options.basis);
  condense_and_keep(r, s);
  // of domains in their order, when all are done
  if (!settings.is_domain) report_conditioning(r.figures.condition, report);
  warn_of_conditioning(r.figures.condition, report);
  s.conditioning = r.figures.condition;
  if (figures != nullptr) *figures = r.figures;
  return s;
}

}  // namespace

Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const ReduceSettings& settings, Report& report,
                    ReductionFigures* figures) {
  return reduce_to(nullptr, mesh, properties, mass, options, settings, report, figures);
}

Superelement reduce(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                    const ReductionOptions& options, const std::vector<Index>& interface,
                    const ReduceSettings& settings, Report& report, ReductionFigures* figures) {
  return reduce_to(&interface, mesh, properties, mass, options, settings, report, figures);
}

}  // namespace cbr
