// SPDX-License-Identifier: GPL-3.0-or-later
// Basis characteristic: the interface moves in a few shapes, by sparse solves of the free component
// or from Craig-Bampton's matrices. The algebra is in the folder characteristic.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "reducer/bases/characteristic/characteristic.hpp"
#include "reducer/bases/characteristic/free_shapes.hpp"
#include "reducer/bases/reduction_steps.hpp"
#include "reducer/judgement/mode_tolerance.hpp"

namespace cbr {
namespace {

// The basis that s has become: its condition, and the interface node that is loose in it.
void examine(Reduction& r, const Superelement& s) {
  const Index loose = examine_characteristic(s, r.figures.characteristic, parts_of_interface(r),
                                             r.figures.condition);
  if (loose >= 0) r.figures.condition.loose_node = node_of_interface_dof(r, loose);
}

void make_shapes(Reduction& r, const InteriorInertia& inertia, Superelement& s) {
  const auto phase = r.report.phase("characteristic modes");
  r.figures.characteristic =
      make_characteristic(r.options.characteristic, parts_of_interface(r), inertia, s);
  examine(r, s);
}

// How far the ten lowest frequencies are beside those of Craig-Bampton's own form.
void compare_with_craig_bampton(Reduction& r, const FreeEigenvalues& free, const Superelement& s) {
  const Vector lambda = s.eigenvalues.tail(s.k() - r.figures.condition.n_rigid);
  const Index ten = std::min({lambda.size(), free.with_basis.size(), n_free_modes_of_tolerance});
  if (ten > 0)
    r.figures.shapes_error =
        (1 - free.with_basis.head(ten).array() / lambda.head(ten).array()).maxCoeff();
}

}  // namespace

void make_basis_characteristic(Reduction& r, Ingredients&& given, Superelement& s) {
  FixedInterfaceModes& modes = given.modes;
  const InterfaceMotions motions = motions_to_judge(r, false, s);
  complete_modes(r, motions, modes, given.condensed, s);
  add_momentum(r, modes.Phi, s);
  judge_reduced_rigid(r, s);
  const FreeEigenvalues free = look_before(r, modes.Phi, s);
  if (r.options.recovery) add_recovery(r, std::move(given.condensed.Psi), std::move(modes.Phi), s);
  const InteriorInertia inertia = interior_inertia(*r.inside);
  r.inside->in_first([&] {
    make_shapes(r, inertia, s);
    look_after(free, r.figures.condition.n_rigid, s);
    compare_with_craig_bampton(r, free, s);
  });
}

bool make_basis_of_free_shapes(Reduction& r, Superelement& s) {
  const CharacteristicOptions& options = r.options.characteristic;
  // several processes have no whole model; rigid motions are all six here
  if (r.model.K.rows() == 0 || s.fixed.any()) return false;
  if (!few_enough(options, !has_parts(r), r.p.n_interior(), s)) return false;
  std::optional<FreeShapes> shapes;
  s.characteristic.statics = static_forces(options, s);
  const FreeComponent model{r.model.K, r.model.M, r.x, r.model.n_rotations};
  std::optional<FreeFactor> free = factorise_free(r, model, s.characteristic.statics.size());
  {
    const auto phase = r.report.phase("shapes and statics");
    shapes = free_shapes(options, model, *free, r.p, s.characteristic.statics, s, r.report);
  }
  if (!shapes) return false;
  r.model.K = SparseMatrix();
  r.model.M = SparseMatrix();
  std::optional<SparseCholesky> own = std::move(free->interior);
  free.reset();
  if (own) {
    take_factor(r, std::move(*own));
  } else {
    factorise_interior(r);
  }
  follow_statically(r.p, *r.factor, *shapes);
  FixedInterfaceModes modes = first_modes(r);
  r.p.K_II = SparseMatrix(r.p.n_interior(), r.p.n_interior());
  Condensation coupled;
  coupled.M_kc = coupling_of_eigenvectors(r.p, modes.lambda, modes.Phi);
  keep_modes(r, modes, coupled);
  keep_lowest(r, modes.Phi);
  if (modes.lambda.size() > 0)
    r.figures.highest_frequency = std::sqrt(modes.lambda.maxCoeff()) / (2 * std::numbers::pi);
  Matrix interior;
  {
    const auto phase = r.report.phase("characteristic modes");
    r.figures.characteristic = take_free_shapes(*shapes, modes.lambda, modes.Phi, r.p, s,
                                                r.options.recovery ? &interior : nullptr);
    examine(r, s);
  }
  add_accuracy_of_shapes(r, modes, shapes->lambda, s);
  if (!r.options.recovery) return true;
  const auto phase = r.report.phase("recovery");
  // u_I = Psi u_c + Phi q, of which the coordinates' own motion of the interface is in Psi u_c
  Matrix Psi = constraint_modes(r);
  interior.noalias() -= Psi * s.characteristic.V;
  add_recovery(r, std::move(Psi), std::move(interior), s);
  return true;
}

}  // namespace cbr
