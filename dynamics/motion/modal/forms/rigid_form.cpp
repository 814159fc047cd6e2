// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/rigid_form.hpp"

#include <algorithm>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {

std::shared_ptr<const DiagonalForm> rigid_form(const Superelement& nodes,
                                               const std::vector<HeldDirection>& held,
                                               const std::string& where) {
  const RigidBody& body = nodes.rigid_body;
  const auto n_turning = std::count_if(nodes.dof_component.begin(), nodes.dof_component.end(),
                                       [](int component) { return component > 2; });
  const Matrix R = rigid_modes(nodes.coordinates, body.center, n_turning / 3);  // 3 N x 6
  Matrix mass = Matrix::Zero(6, 6);
  mass.topLeftCorner(3, 3).diagonal().setConstant(body.mass);
  mass.bottomRightCorner(3, 3) = body.inertia;
  Matrix N = Vector(rigid_scales(body)).asDiagonal();
  if (!held.empty()) N = free_rigid_motions(R, body, displacement_rows(nodes), held);
  auto form = std::make_shared<DiagonalForm>();
  const Index r = form->n_rigid = N.cols();
  form->omega.setZero(r);
  form->V.resize(R.rows(), r);
  form->E.resize(r, 6);
  if (r == 0) return form;
  // V = R N L^-T with N^T R^T M R N = L L^T, so that V^T M V = I
  const Cholesky factor(N.transpose() * mass * N);
  if (!factor.ok())
    throw RunError(where + ": its mass and inertia are not positive, as a rigid body needs");
  factor.divide_by_upper(N);
  form->V.noalias() = R * N;
  form->E.noalias() = N.transpose() * mass;
  return form;
}

}  // namespace cbr
