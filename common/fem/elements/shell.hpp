// SPDX-License-Identifier: GPL-3.0-or-later
// Flat 3- and 4-node shells: membrane, bending, drilling. Element matrices;
// common/fem/shell_model.hpp puts them together.
#pragma once

#include "common/fem/elements/element.hpp"

namespace cbr {

struct ShellProperties {
  Material material;     // E and rho may be 0: a shell for contact alone
  double thickness = 0;  // from 0
};

// 6 n x 6 n, n = 3 or 4 (ElementType::tri3, quad4); X: n x 3. Dofs of a node: u_x u_y u_z theta_x
// theta_y theta_z, rotations about the fixed axes (right-handed). Rank 6 n - 6: no spurious modes
// beyond rigid motions, drilling included.
Matrix shell_stiffness(ElementType type, const Points& X, const ShellProperties& shell);

// Per node: its share of rho t A, and its rotary inertia, the same about all axes.
struct ShellMass {
  Vector mass, rotary;  // n
};
ShellMass shell_lumped_mass(ElementType type, const Points& X, const ShellProperties& shell);

// Consistent: rho t times the integral of N_i N_j, of each translation   (n x n).
Matrix shell_mass(ElementType type, const Points& X, const ShellProperties& shell);
// By what to multiply it for rotations about the points' axes: t^2 / 12 about axes in the shell,
// and about its normal what keeps the drilling rotation from setting explicit steps.
Matrix3 shell_rotary_factors(ElementType type, const Points& X, const ShellProperties& shell);

}  // namespace cbr
