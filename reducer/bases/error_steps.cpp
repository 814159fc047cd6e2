// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/reduction_steps.hpp"

#include <algorithm>

#include "common/base/error.hpp"
#include "reducer/judgement/mode_tolerance.hpp"
#include "reducer/modes/diagonal_form.hpp"

namespace cbr {
namespace {

// Rigid accelerations of the interface, and the interior's inertia forces; no matrices of the
// interface are needed.
InterfaceMotions rigid_accelerations(const Reduction& r, const Superelement& s) {
  InterfaceMotions motions;
  const Vector3& center = s.rigid_body.center;
  const Matrix R_I = rigid_modes(coordinates_of(r, r.p.interior_nodes), center);
  motions.W = rigid_modes(s.coordinates, center);
  motions.Y = r.p.M_II * R_I + r.p.M_IC * motions.W;
  motions.E = motions.Y.transpose() * r.factor->solve(motions.Y);
  motions.E = (0.5 * (motions.E + motions.E.transpose())).eval();
  return motions;
}

// rho_res: residual mass of the fixed-interface modes in a translation, relative; the modes have
// Phi^T (M t)_I of it.
Vector3 residual_mass_share(const InterfaceMotions& rigid, const Matrix& Phi, double mass) {
  const Matrix taken = Phi.transpose() * rigid.Y.leftCols(3);
  return Vector3::Ones() - taken.colwise().squaredNorm().transpose() / mass;
}

}  // namespace

void judge_reduced_rigid(Reduction& r, const Superelement& s) {
  r.inside->in_first([&] {
    const Matrix R =
        reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c()) * free_combinations(s);
    r.figures.condition.reduced_rigid = rigid_residual(s.K_cc, R).value;
  });
}

void add_accuracy(Reduction& r, const InterfaceMotions& motions, const Matrix& Phi,
                  const Cholesky* M_res, Superelement& s) {
  const auto phase = r.report.phase("errors");
  FreeEigenvalues free;
  s.accuracy = accuracy_of(*r.inside, motions, s, Phi, r.figures.condition.n_rigid, r.not_kept,
                           parts(r), true, &free, M_res);
  if (r.options.tolerance)
    judge_tolerance(*r.options.tolerance, s.accuracy->largest_left_out, free.worst_of_ten,
                    r.figures.condition.K_II.scaled, r.report);
  s.accuracy->tolerance = r.options.tolerance.value_or(0);
}

FreeEigenvalues look_before(Reduction& r, const Matrix& Phi, Superelement& s) {
  const auto phase = r.report.phase("errors");
  FreeEigenvalues free;
  const std::vector<Index> part = parts_of_interface(r);
  const InterfaceMotions motions = interface_motions(*r.inside, s, part, false);
  Index n_rigid = 0;
  r.inside->in_first([&] {
    try {
      if (s.n() <= r.settings.diagonal_limit)
        n_rigid = add_lowest_modes(s, part, n_estimated + n_beside);
    } catch (const InputError&) {
      s.omega.resize(0);  // a mass of round-off, with which the other basis may get on
    }
  });
  s.accuracy = accuracy_of(*r.inside, motions, s, Phi, n_rigid, r.not_kept, parts(r), false, &free);
  s.omega.resize(0);
  s.V.resize(0, 0);
  return free;
}

void look_after(const FreeEigenvalues& free, Index n_rigid, Superelement& s) {
  judge_eigenvalues(s.eigenvalues.tail(s.k() - n_rigid), free, *s.accuracy);
}

void add_accuracy_of_shapes(Reduction& r, const FixedInterfaceModes& modes, const Vector& free,
                            Superelement& s) {
  const auto phase = r.report.phase("errors");
  const InterfaceMotions rigid = rigid_accelerations(r, s);
  Superelement held;
  held.eigenvalues = modes.lambda;
  held.rigid_body = s.rigid_body;
  held.dof_node = s.dof_node;
  held.dof_component = s.dof_component;
  s.accuracy = accuracy_of_fixed_modes(*r.inside, rigid, held, modes.Phi,
                                       settled(r.not_kept, *r.inside, held));
  s.accuracy->rho_res = r.figures.characteristic.rho =
      residual_mass_share(rigid, modes.Phi, s.rigid_body.mass);
  const Vector lambda = s.eigenvalues.tail(s.k() - r.figures.characteristic.n_rigid);
  const Index n = std::min({lambda.size(), free.size(), n_estimated});
  FreeEigenvalues known{lambda.head(n), free.head(n).cwiseMin(lambda.head(n))};
  judge_eigenvalues(lambda, known, *s.accuracy);
}

}  // namespace cbr
