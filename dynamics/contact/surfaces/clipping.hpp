// SPDX-License-Identifier: GPL-3.0-or-later
// Convex polygons in a plane: what two faces share when one looks at them along a normal.
#pragma once

#include <array>

#include "common/base/types.hpp"

namespace cbr {

using Vector2 = Eigen::Vector2d;

inline double cross(const Vector2& a, const Vector2& b) { return a[0] * b[1] - a[1] * b[0]; }

// Counter-clockwise. Two quads share at most eight corners, three at most twelve.
struct Polygon {
  std::array<Vector2, 12> x;
  int n = 0;
};

// > 0 counter-clockwise.
double area(const Polygon& polygon);

// What two convex counter-clockwise polygons share (Sutherland and Hodgman 1974,
// doi 10.1145/360767.360802); n < 3: nothing. Where they touch in an edge or a point the result may
// have no area. The corners of `a` and `b` together must not be more than twelve.
Polygon clip(const Polygon& a, const Polygon& b);

}  // namespace cbr
