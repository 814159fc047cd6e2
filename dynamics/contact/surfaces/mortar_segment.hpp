// SPDX-License-Identifier: GPL-3.0-or-later
// Integrals over the shared area of two faces: pure geometry.
#pragma once

#include <array>

#include "common/base/types.hpp"
#include "dynamics/contact/surfaces/projection.hpp"

namespace cbr {

using Vector2 = Eigen::Vector2d;

inline double cross(const Vector2& a, const Vector2& b) { return a[0] * b[1] - a[1] * b[0]; }

// Convex and counter-clockwise: the overlap of two faces seen along a normal. That of two quads has
// at most eight corners, of three at most twelve.
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

// A convex piece of a face seen along a normal: the whole face if it is convex in that view, else
// one of two triangles.
struct FacePiece {
  int n = 0;                    // 3 or 4
  std::array<int, 4> corner{};  // of the face
  Polygon outline;              // counter-clockwise
  // x = origin + s a + t b + s t w; a triangle's s, t are barycentric, w = 0
  Vector2 origin, a, b, w;
  Eigen::Matrix2d inverse;  // of (a, b)
  // relative change of the map's Jacobian over half the piece; 0: affine
  double distortion = 0;
  double area = 0;
};

// Quadratic: with mid-side nodes; biquadratic: a quad with a central node too.
enum class FaceOrder : char { linear, quadratic, biquadratic };

// A face in the plane of `frame` (rows: normal, two tangents).
struct FlatFace {
  bool triangle = false;
  FaceOrder order = FaceOrder::linear;
  int n_pieces = 0;
  std::array<FacePiece, 2> pieces;
};
// Omits pieces without area, or whose orientation about the normal is not `counter_clockwise`.
FlatFace flatten(const FaceCorners& corners, bool triangle, const Matrix3& frame,
                 const Vector3& origin, bool counter_clockwise);

// Corner by node: corners, then mid-side nodes, then the central node. 0 for nodes that a triangle
// or a linear face does not have.
using CornerByNode = Eigen::Matrix<double, 4, 9>;

// Integrals over the shared area of a slave and a master face.
struct Segment {
  CornerByNode D = CornerByNode::Zero();  // D_jk = int N_j N_k dA, both of the slave
  CornerByNode M = CornerByNode::Zero();  // M_jl = int N_j N_l dA, l of the master
  double area = 0;
};
// Integrates with multipliers N_j that are linear on second-order faces too: those of the corners
// alone. They have one sign, as pressures have; nodal forces of a uniform pressure on an 8-node
// face do not. N_k and N_l are those of the face with straight sides, over the area between its
// corners. Slave and master use the same quadrature points, so that rows of D and M have the same
// sum. So linear fields are transferred exactly, independent of the quadrature error, which is 0
// for parallelograms and triangles. It is about 1e-10 for other quads up to a trapezoid of 1 to 5,
// 1e-7 at 1 to 10, 1e-5 at 1 to 40. Omits areas below `sliver` times the smaller face.
Segment integrate(const FlatFace& slave, const FlatFace& master, double sliver = 1e-12);

}  // namespace cbr
