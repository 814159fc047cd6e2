// SPDX-License-Identifier: GPL-3.0-or-later
// Change of a component's inertia as it deforms: centrifugal forces on its coordinates.
#pragma once

#include "reducer/partition/interior.hpp"

namespace cbr {

// Displacements of the six unit strains xx, yy, zz, xy, yz, xz about the center   (3 m x 6)
Matrix unit_strains(const Points& X, const Vector3& center);

// S_j = sym of the integral of rho x u_j^T, of each coordinate's displacement u_j, x from the
// centre of mass: xx, yy, zz, xy, yz, xz as columns, kg m per unit of the coordinate   ((k + c) x
// 6). The inertia changes by 2 (tr S 1 - S), and the centrifugal force of a spin w is |w|^2 tr S -
// w . S w (Shabana, Dynamics of Multibody Systems, 2013, section 5.3). X_I, X_C: places of this
// process's nodes inside and of the nodes on the interface.
Matrix spin_moments(const Interior& interior, const Points& X_I, const Points& X_C,
                    const Vector3& center, const Matrix& Phi);

// P_ij = integral of rho phi_i phi_j^T (3 x 3 blocks, kg per unit of the coordinates squared) for
// Coriolis forces and the inertia of second order   (3 m x 3 m, exactly symmetric). phi_i: modes of
// the full component, whose coordinates are the columns of V ((k + c) x m). Needs m solves.
Matrix spin_couplings(const Interior& interior, const Matrix& Phi, const Matrix& V);

}  // namespace cbr
