// SPDX-License-Identifier: GPL-3.0-or-later
// Rigid motions of a set of nodes and the rigid body that a mass matrix describes.
#include <Eigen/Geometry>
#include <cassert>
#include <cmath>

#include "common/fem/assembly.hpp"
#include "common/linalg/blas_threads.hpp"

namespace cbr {

Matrix rigid_modes(const Points& points, const Vector3& center, Index n_rotations) {
  Matrix R(3 * points.rows(), 6);
  const Index n_translations = points.rows() - n_rotations;
  for (Index i = n_translations; i < points.rows(); ++i)
    R.middleRows(3 * i, 3) << Matrix3::Zero(), Matrix3::Identity();
  for (Index i = 0; i < n_translations; ++i) {
    const Vector3 x = points.row(i).transpose() - center;
    R.block<3, 3>(3 * i, 0).setIdentity();
    // Column k: e_k x (x - c)
    for (int k = 0; k < 3; ++k) R.block<3, 1>(3 * i, 3 + k) = Vector3::Unit(k).cross(x);
  }
  return R;
}

RigidBody rigid_body(const SparseMatrix& M, const Points& points, Index n_rotations) {
  assert(M.rows() == 3 * points.rows());
  RigidBody body;
  if (points.rows() == 0) return body;
  const SingleThreadedBlas one;  // the same bits with any number of threads
  // Twice: first about the mean of the points, then about the centre of mass that this gives, where
  // nothing cancels.
  body.center = points.colwise().mean().transpose();
  for (const bool about_center : {false, true}) {
    const Matrix R = rigid_modes(points, body.center, n_rotations);
    const Eigen::Matrix<double, 6, 6> r = R.transpose() * (M * R);  // R^T M R   (6 x 6)
    body.mass = r.diagonal().head<3>().mean();
    if (about_center) {
      body.inertia = 0.5 * (r.bottomRightCorner<3, 3>() + r.bottomRightCorner<3, 3>().transpose());
    } else if (body.mass > 0) {
      // t_i^T M (e_k x x) = m (e_k x c)_i: each component of c twice, in two translations.
      const Vector3 moment(r(1, 5) - r(2, 4), r(2, 3) - r(0, 5), r(0, 4) - r(1, 3));
      body.center += moment / (2 * body.mass);
    }
  }
  return body;
}

Vector rigid_scales(const RigidBody& body) {
  const double size = std::sqrt(body.inertia.trace()) / std::sqrt(body.mass);
  Vector scales = Vector::Ones(6);
  scales.tail(3).setConstant(size > 0 && std::isfinite(size) ? 1 / size : 1);
  return scales;
}

}  // namespace cbr
