// SPDX-License-Identifier: GPL-3.0-or-later

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/base/error.hpp"
#include "reducer/bases/engine.hpp"
#include "reducer/judgement/mode_tolerance.hpp"
#include "reducer/modes/interior_loads.hpp"

namespace cbr {
namespace {

Index n_modes_wanted(Reduction& r) {
  check_modes_wanted(r.options);
  if (r.options.modes) return *r.options.modes;
  const auto phase = r.report.phase("modes: count below cutoff");
  return r.engine->count_below(r, *r.options.cutoff_hz);
}

void check_found(Reduction& r, const FixedInterfaceModes& modes) {
  r.figures.mode_method = modes.method;
  r.figures.modes_proven = modes.proven;
  r.figures.condition.counts = modes.counts;
  r.figures.condition.modes = check_modes(*r.inside, modes.lambda, modes.Phi);
  require_independent(*r.inside, modes.Phi, r.figures.condition.modes);
}

FixedInterfaceModes modes_to_compute(Reduction& r) {
  const Index wanted = n_modes_wanted(r), n_I = r.p.n_interior();
  if (r.options.pick == Pick::participation && !r.options.modes)
    throw InputError("pick: participation needs `modes`: a cutoff keeps every mode below it");
  const Index candidates = n_mode_candidates(r.options.pick, wanted, n_I);
  const auto phase = r.report.phase("fixed-interface modes");
  r.report.progress("fixed-interface modes", 0);
  FixedInterfaceModes modes = r.engine->lowest_modes(r, candidates);
  if (r.options.cutoff_hz && wanted > 0) {
    const double cutoff = 2 * std::numbers::pi * *r.options.cutoff_hz;
    if (modes.lambda(wanted - 1) > cutoff * cutoff * (1 + basis_precision)) {
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

void pick_by_tolerance(Reduction& r, const InterfaceMotions& motions, const Superelement& s,
                       FixedInterfaceModes& modes, Condensation& condensed) {
  const auto phase = r.report.phase("fixed-interface modes");
  ModesOfTolerance found = [&] {
    try {
      return has_parts(r) ? modes_of_tolerance(r.p, parts(r), s, *r.options.tolerance, r.report)
                          : modes_of_tolerance(r.p, *r.factor, motions, s, parts_of_interface(r),
                                               *r.options.tolerance, r.report);
    } catch (const LostMass& lost) {
      throw InputError(lost.what() + ("; first at " + r.figures.condition.weakest));
    }
  }();
  r.figures.n_candidates = found.n_candidates;
  r.not_kept = std::move(found.not_kept);
  modes = std::move(found.modes);
  check_found(r, modes);
  condensed.M_kc = mode_coupling(*r.inside, modes.Phi);
}

// Rows of this process.
void keep_own_rows(const Interior& inside, Matrix& F_I) {
  if (inside.own_nodes() != nullptr) F_I = Matrix(F_I(dofs_of(*inside.own_nodes()), Eigen::all));
}

// Residual vectors of the interior loads, after the modes; and the generalised loads.
void add_loads(Reduction& r, FixedInterfaceModes& modes, Condensation& condensed, Superelement& s) {
  InteriorLoads loads = interior_loads(r.mesh, r.model, r.p, r.options.loads);
  if (!loads.any()) return;
  keep_own_rows(*r.inside, loads.F_I);
  const auto phase = r.report.phase("residual vectors");
  s.n_residual = has_parts(r) ? add_residual_vectors(parts(r), loads.F_I, modes)
                              : add_residual_vectors(*r.inside, loads.F_I, modes);
  const Matrix more = mode_coupling(*r.inside, modes.Phi.rightCols(s.n_residual));
  condensed.M_kc.conservativeResize(modes.lambda.size(), r.p.n_interface());
  condensed.M_kc.bottomRows(s.n_residual) = more;
  s.loads = generalised_loads(*r.inside, loads, modes.Phi);
}

}  // namespace

FixedInterfaceModes first_modes(Reduction& r) {
  if (!r.options.is_massless() && !r.options.tolerance) return modes_to_compute(r);
  check_modes_wanted(r.options);
  FixedInterfaceModes none;
  none.Phi.resize(r.p.n_interior(), 0);
  return none;
}

void keep_modes(Reduction& r, FixedInterfaceModes& modes, Condensation& condensed) {
  r.not_kept.Phi.resize(r.inside->n_rows(), 0);
  r.not_kept.beyond = modes.next;
  if (modes.lambda.size() > 0)
    r.not_kept.beyond = std::max(modes.next, modes.lambda(modes.lambda.size() - 1));
  if (r.options.pick != Pick::participation || modes.lambda.size() <= *r.options.modes) return;
  const std::vector<Index> kept = r.inside->list_from_first(
      [&] { return modes_by_participation(condensed.M_kc, *r.options.modes); });
  std::vector<Index> others;
  for (Index j = 0; j < modes.lambda.size(); ++j)
    if (!std::binary_search(kept.begin(), kept.end(), j)) others.push_back(j);
  r.not_kept.lambda = modes.lambda(others);
  r.not_kept.Phi = modes.Phi(Eigen::all, others);
  modes.lambda = Vector(modes.lambda(kept));
  modes.Phi = Matrix(modes.Phi(Eigen::all, kept));
  condensed.M_kc = Matrix(condensed.M_kc(kept, Eigen::all));
}

InterfaceMotions motions_to_judge(Reduction& r, bool is_judged, const Superelement& s) {
  if (!is_judged && (!r.options.tolerance || has_parts(r))) return {};
  const auto phase = r.report.phase("errors");
  return interface_motions(*r.inside, s, parts_of_interface(r));
}

void complete_modes(Reduction& r, const InterfaceMotions& motions, FixedInterfaceModes& modes,
                    Condensation& condensed, Superelement& s) {
  if (r.options.tolerance) {
    pick_by_tolerance(r, motions, s, modes, condensed);
    if (needs_one_Psi(r.figures.condition.K_II.scaled)) couple_again(r, modes.Phi, condensed);
  }
  if (!r.options.loads.empty()) add_loads(r, modes, condensed, s);
  keep_lowest(r, modes.Phi.leftCols(modes.Phi.cols() - s.n_residual));
  s.eigenvalues = modes.lambda;
  s.M_kc = std::move(condensed.M_kc);
  const Index own = s.k() - s.n_residual;
  if (own > 0)
    r.figures.highest_frequency =
        std::sqrt(s.eigenvalues.head(own).maxCoeff()) / (2 * std::numbers::pi);
}

void keep_lowest(Reduction& r, const Eigen::Ref<const Matrix>& Phi) {
  constexpr Index n_listed = 6;  // in the summary
  r.lowest = Phi.leftCols(std::min(n_listed, Phi.cols()));
}

}  // namespace cbr
