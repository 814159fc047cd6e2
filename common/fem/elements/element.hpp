// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/fem/elements: element matrices and shells.
//
// Element matrices of linear elasticity. One family per .cpp: shape functions, quadrature,
// stiffness, mass.
#pragma once

#include <optional>

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
  // Given: a cylinder, whose axis runs through it along the third row. Axes 1 and 2 are then radial
  // and tangential.
  std::optional<Vector3> center = {};
};
// E_i / (1 - nu nu) ..., the stiffness of the normal strains, material's axes   (3 x 3, symmetric).
// Its eigenvalues are positive where the constants are those of a material.
Matrix3 normal_stiffness(const Orthotropy& orthotropy);
bool is_definite(const Orthotropy& orthotropy);  // every strain costs energy; moduli are above 0

struct Material {
  double youngs_modulus = 0;  // E, > 0
  double poissons_ratio = 0;  // nu, in (-1, 0.5)
  double density = 0;         // rho, > 0
  // in place of E and nu, which then are the mean of E_i and 0: for magnitudes only
  std::optional<Orthotropy> orthotropy = {};
};

// Only hex8 has them all. `reduced` of a hex20 has 2 x 2 x 2 points and of a wedge15 3 x 3, all
// others 3 x 3 x 3 and 6 x 3. The other types have the one formulation that fits them.
enum class HexFormulation {
  full,          // 2 x 2 x 2 points
  incompatible,  // Wilson's modes in Taylor's corrected form (Taylor, Beresford, Wilson 1976),
                 // Jacobian at the centre
  hourglass,     // one point and Flanagan-Belytschko hourglass control (1981)
  reduced,       // the same with CalculiX's coefficient: C3D8R; a hex20: C3D20R, a wedge15: C3D15
};

// The material, with the axes that it has at x.
Material material_at(const Material& material, const Vector3& x);

enum class MassKind { lumped, consistent };

// X: n x 3 node coordinates in Exodus order. Returned K is 3n x 3n, dofs (node, component) with the
// component fastest. Precondition: check_element says the element is usable.
Matrix element_stiffness(ElementType type, HexFormulation hex, const Points& X,
                         const Material& material);

// Consistent mass as n x n (the same for x, y, z). Of a hex20 or wedge15 `reduced` it has the
// points of the stiffness, as in CalculiX: rank 8 of 20 and 9 of 15.
Matrix element_mass(ElementType type, const Points& X, double density,
                    HexFormulation hex = HexFormulation::full);

// Lumped mass, n, all > 0, sum rho V: row sums for linear elements, diagonal scaling (Hinton, Rock,
// Zienkiewicz 1976) for quadratic ones.
Vector element_lumped_mass(ElementType type, const Points& X, double density);

// Smallest Jacobian determinant over the quadrature points and corner nodes, relative to V /
// V_reference of the element: <= 0 means inverted or degenerate, 1 a parallelepiped. Never NaN for
// finite X.
double element_quality(ElementType type, const Points& X);

// Cauchy stress (xx yy zz xy yz zx) at the centroid for nodal displacements u (n x 3).
Eigen::Matrix<double, 6, 1> element_stress(ElementType type, HexFormulation hex, const Points& X,
                                           const Material& material, const Points& u);

}  // namespace cbr
