// SPDX-License-Identifier: GPL-3.0-or-later
// Convex polygons in a plane: the overlap of two faces seen along a normal.
#pragma once

#include <array>

#include "common/base/types.hpp"

namespace cbr {

using Vector2 = Eigen::Vector2d;

inline double cross(const Vector2& a, const Vector2& b) { return a[0] * b[1] - a[1] * b[0]; }

// Counter-clockwise. The intersection of two quads has at most eight corners, of three at most
// twelve.
struct Polygon {
  std::array<Vector2, 12> x;
  int n = 0;
};

// > 0 counter-clockwise.
double area(const Polygon& polygon);

// Intersection of two convex counter-clockwise polygons (Sutherland and Hodgman 1974, doi
// 10.1145/360767.360802); n < 3: empty. It may have no area if they touch at an edge or a point.
// `a` and `b` together must have at most twelve corners.
Polygon clip(const Polygon& a, const Polygon& b);

}  // namespace cbr
