// SPDX-License-Identifier: GPL-3.0-or-later
// The reduced matrices that a superelement stands for. Its file: superelement_file.cpp.
#include "common/superelement/superelement.hpp"

#include <Eigen/Geometry>

#include "common/linalg/dense.hpp"

namespace cbr {

Matrix reduced_stiffness(const Superelement& s) {
  // K = [diag(eigenvalues) 0; 0 K_cc]   (n x n)
  Matrix K = Matrix::Zero(s.n(), s.n());
  K.diagonal().head(s.k()) = s.eigenvalues;
  K.bottomRightCorner(s.c(), s.c()) = s.K_cc;
  return K;
}

Matrix reduced_mass(const Superelement& s) {
  // M = [I M_kc; M_kc^T M_cc]   (n x n)
  Matrix M = Matrix::Identity(s.n(), s.n());
  M.topRightCorner(s.k(), s.c()) = s.M_kc;
  M.bottomLeftCorner(s.c(), s.k()) = s.M_kc.transpose();
  M.bottomRightCorner(s.c(), s.c()) = s.M_cc;
  return M;
}

Matrix reduced_rigid_modes(const Superelement& s, const Vector3& center) {
  // Translation e_a: u = e_a, theta = 0. Rotation about e_a: u = e_a x (x - center), theta = e_a.
  // R = [0; R_c]   (n x 6)
  Matrix R = Matrix::Zero(s.n(), 6);
  for (Index i = 0; i < s.c(); ++i) {
    const Vector3 arm = s.coordinates.row(s.dof_node[i]).transpose() - center;
    const int component = s.dof_component[i];
    for (int axis = 0; axis < 3; ++axis) {
      R(s.k() + i, axis) = component == axis ? 1.0 : 0.0;
      R(s.k() + i, 3 + axis) = component < 3           ? Vector3::Unit(axis).cross(arm)(component)
                               : component - 3 == axis ? 1.0
                                                       : 0.0;
    }
  }
  return R;
}

Matrix free_combinations(const Superelement& s) {
  if (!s.fixed.any()) return Matrix::Identity(6, 6);
  return rigid_scales(s.rigid_body).asDiagonal() * null_space(s.fixed.resisted, 1e-9);
}

Vector3 residual_mass_share(const Superelement& s) {
  Vector3 share = Vector3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    if (s.fixed.any() && s.fixed.resisted.col(axis).norm() > 1e-9) continue;  // none there
    Vector r(s.c());  // rigid translation of the interface   (c)
    for (Index i = 0; i < s.c(); ++i) r(i) = s.dof_component[i] == axis ? 1.0 : 0.0;
    // rho = r^T (M_cc - M_kc^T M_kc) r / r^T M_cc r
    const double whole = r.dot(s.M_cc * r);
    // BLAS complains, on stdout, about a matrix without rows.
    const double in_modes = s.k() > 0 ? (s.M_kc * r).squaredNorm() : 0.0;
    if (whole > 0) share(axis) = 1.0 - in_modes / whole;
  }
  return share;
}

}  // namespace cbr
