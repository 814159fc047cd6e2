// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/fem/elements: element matrices and shells.
//
// Element matrices of linear elasticity. One family per .cpp: shape functions, quadrature,
// stiffness, mass.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/base/types.hpp"
#include "common/mesh/element_type.hpp"

namespace cbr {

// Three planes of symmetry, normal to the material's axes 1, 2, 3.
struct Orthotropy {
  Vector3 youngs_moduli;  // E_1, E_2, E_3
  // nu_12, nu_23, nu_13; nu_ij: -strain along j per strain along i of a pull along i
  Vector3 poissons_ratios;
  Vector3 shear_moduli;  // G_12, G_23, G_13
  // rows: the material's axes in those of the component, orthonormal, right-handed
  Matrix3 axes = Matrix3::Identity();
};
// E_i / (1 - nu nu) ..., the stiffness of the normal strains, material's axes   (3 x 3, symmetric).
// Its eigenvalues are positive where the constants are those of a material.
Matrix3 normal_stiffness(const Orthotropy& orthotropy);

struct Material {
  double youngs_modulus = 0;  // E, > 0
  double poissons_ratio = 0;  // nu, in (-1, 0.5)
  double density = 0;         // rho, > 0
  // in place of E and nu, which then are the mean of E_i and 0: for magnitudes only
  std::optional<Orthotropy> orthotropy = {};
};

// Only 8-node hexes have a choice; the other types have the one formulation that fits them.
enum class Hex8Formulation {
  full,          // 2 x 2 x 2 points
  incompatible,  // Wilson's modes in Taylor's corrected form (Taylor, Beresford, Wilson 1976),
                 // Jacobian at the centre
  hourglass,     // one point and Flanagan-Belytschko hourglass control (1981)
};
// hex8 | hex8-incompatible | hex8-hourglass; InputError
Hex8Formulation parse_hex8_formulation(std::string_view text);
std::string_view name(Hex8Formulation formulation);

enum class MassKind { lumped, consistent };

// X: n x 3 node coordinates in Exodus order. Returned K is 3n x 3n, dofs (node, component) with the
// component fastest. Precondition: check_element says the element is usable.
Matrix element_stiffness(ElementType type, Hex8Formulation hex8, const Points& X,
                         const Material& material);

// Consistent mass as n x n (the same for x, y, z).
Matrix element_mass(ElementType type, const Points& X, double density);

// Lumped mass, n, all > 0, sum rho V: row sums for linear elements, diagonal scaling (Hinton, Rock,
// Zienkiewicz 1976) for quadratic ones.
Vector element_lumped_mass(ElementType type, const Points& X, double density);

// Smallest Jacobian determinant over the quadrature points and corner nodes, relative to V /
// V_reference of the element: <= 0 means inverted or degenerate, 1 a parallelepiped. Never NaN for
// finite X.
double element_quality(ElementType type, const Points& X);

// Cauchy stress (xx yy zz xy yz zx) at the centroid for nodal displacements u (n x 3).
Eigen::Matrix<double, 6, 1> element_stress(ElementType type, Hex8Formulation hex8, const Points& X,
                                           const Material& material, const Points& u);

}  // namespace cbr
