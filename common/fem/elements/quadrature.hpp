// SPDX-License-Identifier: GPL-3.0-or-later
// Quadrature rules as tables of points and weights. All weights are positive, all points inside.
#pragma once

#include <vector>

#include "common/base/types.hpp"

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

}  // namespace cbr
