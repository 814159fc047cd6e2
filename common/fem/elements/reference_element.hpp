// SPDX-License-Identifier: GPL-3.0-or-later
// Shape functions of the volume elements, tabulated at their quadrature points. For the .cpp of
// this folder and its tests.
#pragma once

#include <vector>

#include "common/base/types.hpp"
#include "common/mesh/element_type.hpp"

namespace cbr {

struct QuadraturePoint {
  Vector3 xi;
  double weight = 0;
};
using QuadratureRule = std::vector<QuadraturePoint>;

struct LinePoint {
  double xi = 0, weight = 0;
};

// Gauss-Legendre on [-1, 1], n = 1, 2, 3: exact to degree 2 n - 1.
std::vector<LinePoint> gauss_line(int n);

// [-1, 1]^3, n x n x n Gauss points.
QuadratureRule gauss_hex(int n);

// Triangle (0,0) (1,0) (0,1), third coordinate 0: 3 points of degree 2; 6 points of degree 4
// (Strang and Fix 1973, Cowper 1973).
QuadratureRule triangle_rule(int n_points);

// Tetrahedron with corners 0, e_1, e_2, e_3: 1 point (degree 1), 4 points (degree 2), 14 points
// (degree 5, Walkington 2000).
QuadratureRule tetrahedron_rule(int n_points);

// Triangle rule times Gauss line: wedge with zeta in [-1, 1].
QuadratureRule wedge_rule(int n_triangle, int n_line);

// Pyramid in the coordinates (a, b, zeta) of [-1, 1]^2 x [0, 1], xi = a (1 - zeta), eta = b (1 -
// zeta): n x n Gauss points in a, b times 1 or 2 Gauss-Jacobi points in zeta (exact to degree 1 or
// 3 beside the weight (1 - zeta)^2, which the weights contain).
QuadratureRule pyramid_rule(int n, int n_zeta);

struct ShapeFunctions {
  Vector N;   // n
  Points dN;  // n x 3, derivatives by the reference coordinates
};

// One family per file. xi in [-1, 1]^3.
ShapeFunctions hex8_shape(const Vector3& xi);
ShapeFunctions hex20_shape(const Vector3& xi);
ShapeFunctions hex27_shape(const Vector3& xi);
// xi = the last three barycentric coordinates.
ShapeFunctions tet4_shape(const Vector3& xi);
ShapeFunctions tet10_shape(const Vector3& xi);
// Two barycentric coordinates of the triangle, zeta in [-1, 1].
ShapeFunctions wedge6_shape(const Vector3& xi);
ShapeFunctions wedge15_shape(const Vector3& xi);
// The rational functions (Bedrosian 1992), in the coordinates (a, b, zeta) of pyramid_rule(), where
// they are the polynomials N_i = (1 - zeta) n_i(a, b), N_5 = zeta. dN are the derivatives by a and
// b divided by (1 - zeta), and by zeta: the factor (1 - zeta)^2 of the Jacobian determinant,
// is in the weights of pyramid_rule(). So nothing is singular, not even at the apex.
ShapeFunctions pyramid5_shape(const Vector3& xi);

ShapeFunctions shape_functions(ElementType type, const Vector3& xi);
// Reference coordinates of node a: where its shape function is 1 and all others are 0. Of the apex
// of a pyramid, where the first two coordinates mean nothing, those in the middle.
Vector3 place_of_node(ElementType type, Index a);

struct ShapeTable {
  std::vector<double> weight;  // n_q
  Matrix N;                    // n x n_q
  std::vector<Points> dN;      // n_q of n x 3
  Index size() const { return static_cast<Index>(weight.size()); }
};

struct ReferenceElement {
  double volume = 0;
  ShapeTable stiffness, mass;  // at their quadrature points
  ShapeTable corners, center;  // weights 0
  ShapeTable reduced;          // of HexFormulation::reduced: hex20 2 x 2 x 2, wedge15 3 x 3 points
};

// Tabulated once. Precondition: a volume element.
//            stiffness           mass
//  hex8      2 x 2 x 2           2 x 2 x 2
//  hex20/27  3 x 3 x 3           3 x 3 x 3
//  tet4      1                   4
//  tet10     14                  14: exact for straight edges; 14 points also in the stiffness
//  because the usual 4 are exact
//                                for straight edges only and fail the patch test on curved ones
//  wedge6    3 x 2               6 x 3
//  wedge15   6 x 3               6 x 3
//  pyramid5  2 x 2 x 1           3 x 3 x 2: the gradients do not depend on zeta, and their
//  integrals are exact with 2 x 2 points
const ReferenceElement& reference_element(ElementType type);

}  // namespace cbr
