// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/geometry_body.hpp"

#include "common/fem/elements/shell.hpp"

namespace cbr {
namespace {

Points points_of(const Mesh& mesh, const Block& block, Index e) {
  Points X(block.connectivity.cols(), 3);
  for (Index i = 0; i < X.rows(); ++i) X.row(i) = mesh.coordinates.row(block.connectivity(e, i));
  return X;
}

// visit(points about `origin`, n x n consistent mass) of every solid and shell.
template <typename Visit>
void for_each_element(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                      const Vector3& origin, const Visit& visit) {
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    if (!is_structure(block)) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const Points X = points_of(mesh, block, e);
      const Matrix M = dimension(block.type) == 3
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
