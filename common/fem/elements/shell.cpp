// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/shell.hpp"

#include <algorithm>
#include <array>

#include "common/fem/elements/shell_plane.hpp"

namespace cbr {
namespace {

using shell::Plane;

// k(dofs, dofs) += part
void add(const Matrix& part, const std::array<Index, 3>& dofs, Matrix& k) {
  const Index n = part.rows() / 3;
  for (Index j = 0; j < 3 * n; ++j)
    for (Index i = 0; i < 3 * n; ++i)
      k(6 * (i / 3) + dofs[i % 3], 6 * (j / 3) + dofs[j % 3]) += part(i, j);
}

// 6 n x 6 n: the local dofs of the flat element from those of the nodes in the points' axes. A node
// off the mean plane is tied to its projection by a rigid link: u = u_i - z theta_y, v = v_i + z
// theta_x. Rigid motions pass exactly.
Matrix to_plane(const Plane& plane) {
  const Index n = plane.x.rows();
  Matrix T = Matrix::Zero(6 * n, 6 * n);
  for (Index i = 0; i < n; ++i) {
    T.block<3, 3>(6 * i, 6 * i) = plane.axes;
    T.block<3, 3>(6 * i + 3, 6 * i + 3) = plane.axes;
    T.block<1, 3>(6 * i, 6 * i + 3) = -plane.z(i) * plane.axes.row(1);
    T.block<1, 3>(6 * i + 1, 6 * i + 3) = plane.z(i) * plane.axes.row(0);
  }
  return T;
}

}  // namespace

Matrix shell_stiffness(ElementType type, const Points& X, const ShellProperties& shell) {
  const Plane plane = shell::flatten(type, X);
  const Index n = X.rows();
  const double nu = shell.material.poissons_ratio,
               E_t = shell.material.youngs_modulus * shell.thickness;
  if (E_t == 0) return Matrix::Zero(6 * n, 6 * n);
  Matrix k = Matrix::Zero(6 * n, 6 * n);
  add(shell::membrane_stiffness(plane, nu), {0, 1, 5}, k);
  add(shell::bending_stiffness(plane, nu, shell.thickness / plane.length), {2, 3, 4}, k);
  // Energies E t length^2 q^T k q / 2 with q = (displacements / length, rotations).
  const Matrix T = to_plane(plane);
  Matrix K = E_t * (T.transpose() * k * T);
  for (Index j = 0; j < 6 * n; ++j)
    for (Index i = j; i < 6 * n; ++i) {
      if (i % 6 >= 3) K(i, j) *= plane.length;
      if (j % 6 >= 3) K(i, j) *= plane.length;
      K(j, i) = K(i, j);
    }
  return K;
}

ShellMass shell_lumped_mass(ElementType type, const Points& X, const ShellProperties& shell) {
  const Plane plane = shell::flatten(type, X);
  Vector share = Vector::Zero(X.rows());
  for (const shell::PlanePoint& point : shell::plane_points(plane)) share += point.weight * point.N;
  share *= plane.length * plane.length;
  ShellMass lumped;
  lumped.mass = shell.material.density * shell.thickness * share;
  lumped.rotary =
      std::max(shell.thickness * shell.thickness / 12, shell::rotary_area_factor * share.sum()) *
      lumped.mass;
  return lumped;
}

Matrix shell_mass(ElementType type, const Points& X, const ShellProperties& shell) {
  const Plane plane = shell::flatten(type, X);
  Matrix M = Matrix::Zero(X.rows(), X.rows());
  for (const shell::PlanePoint& point : shell::plane_points(plane))
    M += point.weight * point.N * point.N.transpose();
  return shell.material.density * shell.thickness * plane.length * plane.length * M;
}

Matrix3 shell_rotary_factors(ElementType type, const Points& X, const ShellProperties& shell) {
  const Plane plane = shell::flatten(type, X);
  double area = 0;
  for (const shell::PlanePoint& point : shell::plane_points(plane)) area += point.weight;
  area *= plane.length * plane.length;
  const double of_fibre = shell.thickness * shell.thickness / 12;
  const Vector3 factors(of_fibre, of_fibre,
                        std::max(of_fibre, shell::consistent_drilling_area_factor * area));
  return plane.axes.transpose() * factors.asDiagonal() * plane.axes;
}

}  // namespace cbr
