// SPDX-License-Identifier: GPL-3.0-or-later
// Basis craig-bampton: all dofs of the interface, and modes with the interface held. Its errors are
// told here.
#include <algorithm>
#include <optional>
#include <utility>

#include "reducer/bases/reduction_steps.hpp"
#include "reducer/condensation/superelement_algebra.hpp"
#include "reducer/judgement/condition_numbers.hpp"
#include "reducer/modes/diagonal_form.hpp"
#include "reducer/modes/interior_loads.hpp"

namespace cbr {
namespace {

// Only of a component that can rotate by itself.
void add_spin_moments(const Reduction& r, const Matrix& Phi, Superelement& s) {
  if (r.settings.is_domain || has_parts(r) || r.p.n_points > 0 || s.fixed.any()) return;
  s.spin_moments = spin_moments(*r.inside, coordinates_of(r, own_nodes(r)),
                                coordinates_of(r, r.p.interface_nodes), s.rigid_body.center, Phi);
}

constexpr Index n_coupled = 8;

// Of the lowest elastic modes of the diagonal form.
void add_spin_couplings(const Reduction& r, const Matrix& Phi, Superelement& s) {
  constexpr Index n_rigid = 6;
  if (s.spin_moments.size() == 0 || !r.settings.is_diagonal_read) return;
  const Matrix V = r.inside->from_first([&] {
    if (!s.has_diagonal_form() || r.figures.condition.n_rigid != n_rigid) return Matrix();
    return Matrix(s.V.middleCols(n_rigid, std::min(n_coupled, s.n() - n_rigid)));
  });
  if (V.cols() == 0) return;
  const auto phase = r.report.phase("spin couplings");
  s.spin_couplings = spin_couplings(*r.inside, Phi, V);
}

// Returns residual_mass_factor().
Cholesky add_diagonal(Reduction& r, Superelement& s) {
  // Where nothing reads the diagonal form, errors are estimated from its lowest modes
  const auto phase = r.report.phase(r.settings.is_diagonal_read ? "diagonal form" : "errors");
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

}  // namespace

void make_basis_craig_bampton(Reduction& r, Ingredients&& given, Superelement& s) {
  FixedInterfaceModes& modes = given.modes;
  // Errors are of the whole component, not of its domains
  const bool is_judged = !r.settings.is_domain;
  const InterfaceMotions motions = motions_to_judge(r, is_judged, s);
  complete_modes(r, motions, modes, given.condensed, s);
  add_momentum(r, modes.Phi, s);
  add_spin_moments(r, modes.Phi, s);
  judge_reduced_rigid(r, s);
  if (is_judged) {
    std::optional<Cholesky> M_res;
    r.inside->in_first([&] { M_res = add_diagonal(r, s); });
    add_spin_couplings(r, modes.Phi, s);
    add_accuracy(r, motions, modes.Phi, M_res ? &*M_res : nullptr, s);
  }
  if (!r.settings.is_diagonal_read) {
    s.omega.resize(0);
    s.V.resize(0, 0);
  }
  if (r.options.recovery) add_recovery(r, std::move(given.condensed.Psi), std::move(modes.Phi), s);
}

}  // namespace cbr
