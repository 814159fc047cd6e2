// SPDX-License-Identifier: GPL-3.0-or-later
// A shell element laid flat and made dimensionless, and its integrals there. For the .cpp of this
// folder.
#pragma once

#include <vector>

#include "common/fem/elements/shell.hpp"

namespace cbr::shell {

// Of the tie between a node's drilling rotation and the continuum's, over the shear modulus: any
// value above 0 converges.
constexpr double drilling_modulus = 1;
// Rotary inertia is mass times max(t^2 / 12, this times the element's area): docs/theory.md,
// "Shells".
constexpr double rotary_area_factor = 0.125;
// Of a consistent mass, and of the drilling rotation alone: its squared frequencies are three times
// those of a lumped one.
constexpr double consistent_drilling_area_factor = rotary_area_factor / 3;

// Lengths in units of `length`, so that nothing depends on the element's size: x, y in the mean
// plane, z the height of a node above it (0 for a triangle). Stiffnesses of this folder are in
// units of E t: the energy is E t length^2 q^T k q / 2 for q = (displacements / length, rotations).
struct Plane {
  Eigen::Matrix<double, Eigen::Dynamic, 2> x;  // n
  Vector z;                                    // n
  Matrix3 axes;                                // rows: local x, y, z in the axes of the points
  double length = 0;                           // longest edge or diagonal
};
Plane flatten(ElementType type, const Points& X);

// Smallest Jacobian at a corner (quad4), or twice the area (tri3), of the dimensionless element: at
// most about 1; <= 0 is inverted. 0 when the points are not finite or coincide.
double corner_jacobian(ElementType type, const Points& X);
// A shell whose smallest one is below has no plane worth the name.
constexpr double flat_corner = 1e-10;

// At one quadrature point: functions of the corners, of the sides (side k joins nodes k and k + 1),
// and vector functions of the sides whose component along a side is constant, with integral 1 along
// their own side and 0 along the others.
struct PlanePoint {
  double weight = 0;  // times det J
  Vector N;           // n
  using Slopes = Eigen::Matrix<double, Eigen::Dynamic, 2>;
  Slopes dN;    // n, d/dx d/dy
  Slopes dP;    // n: of P_k, quadratic along side k, 1 at its middle
  Slopes edge;  // n
  // quad4: 2, of 1 - xi^2 and 1 - eta^2 in Taylor's corrected form, whose mean over the element
  // vanishes
  Slopes dI;
};
// tri3: 3 points, quad4: 2 x 2.
std::vector<PlanePoint> plane_points(const Plane& plane);

// 3 n x 3 n. Dofs of a node: u, v, theta_z.
Matrix membrane_stiffness(const Plane& plane, double poissons_ratio);
// 3 n x 3 n. Dofs of a node: w, theta_x, theta_y. thickness in units of plane.length.
Matrix bending_stiffness(const Plane& plane, double poissons_ratio, double thickness);

// Of the same dofs, 3 x 3 n: means over the element of eps_xx, eps_yy, gamma_xy (those of
// incompatible modes are 0), and of the curvatures beta_x,x  beta_y,y  beta_x,y + beta_y,x of the
// fibres, u = z beta_x, v = z beta_y.
Matrix mean_strains(const Plane& plane);
Matrix mean_curvatures(const Plane& plane, double poissons_ratio, double thickness);

}  // namespace cbr::shell
