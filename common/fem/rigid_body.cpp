// SPDX-License-Identifier: GPL-3.0-or-later
// Rigid motions of a set of nodes, and the rigid body that a mass matrix or a mesh describes.
#include <Eigen/Geometry>
#include <cassert>
#include <cmath>

#include "common/fem/block_elements.hpp"
#include "common/fem/elements/shell.hpp"
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
    const Matrix6 r = R.transpose() * (M * R);  // R^T M R   (6 x 6)
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

namespace {

// visit(points about `origin`, n x n consistent mass) of every solid and shell.
template <typename Visit>
void for_each_element(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                      const Vector3& origin, const Visit& visit) {
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    if (!is_structure(block)) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const Points X = element_points(mesh, block, e);
      const Matrix M = is_volume(block)
                           ? element_mass(block.type, X, properties[b].material.density)
                           : shell_mass(block.type, X, {properties[b].material, block.thickness});
      visit(Points(X.rowwise() - origin.transpose()), M);
    }
  }
}

}  // namespace

RigidBody rigid_body_of_geometry(const Mesh& mesh, const std::vector<BlockProperties>& properties) {
  RigidBody body;
  if (mesh.coordinates.rows() == 0) return body;
  const Vector3 middle = mesh.coordinates.colwise().mean().transpose();
  Vector3 moment = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();  // int rho x x^T dV about `middle`
  for_each_element(mesh, properties, middle, [&](const Points& X, const Matrix& M) {
    const Vector sums = M.colwise().sum().transpose();
    body.mass += sums.sum();
    moment += X.transpose() * sums;
    second += X.transpose() * M * X;
  });
  if (!(body.mass > 0)) return body;
  const Vector3 centre = moment / body.mass;
  body.center = middle + centre;
  second -= body.mass * centre * centre.transpose();
  body.inertia = second.trace() * Matrix3::Identity() - second;
  return body;
}

}  // namespace cbr
