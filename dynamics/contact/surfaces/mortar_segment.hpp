// SPDX-License-Identifier: GPL-3.0-or-later
// What two faces share, integrated: pure geometry.
#pragma once

#include <array>
#include <vector>

#include "dynamics/contact/surfaces/clipping.hpp"
#include "dynamics/contact/surfaces/projection.hpp"

namespace cbr {

// A convex piece of a face seen along a normal: the whole face, or one of the two triangles of a
// quad that is not convex from there.
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

// Quadratic: with nodes between the corners; biquadratic: a quad with one in the middle, too.
enum class FaceOrder : char { linear, quadratic, biquadratic };

// A face in the plane of `frame` (rows: normal, two tangents).
struct FlatFace {
  bool triangle = false;
  FaceOrder order = FaceOrder::linear;
  int n_pieces = 0;
  std::array<FacePiece, 2> pieces;
};
// Pieces without area, or whose sense of rotation about the normal is not `counter_clockwise`, are
// left out.
FlatFace flatten(const FaceCorners& corners, bool triangle, const Matrix3& frame,
                 const Vector3& origin, bool counter_clockwise);

// Corner by node: corners, then mid-side nodes, then the middle. What a triangle or a linear face
// does not have is 0.
using CornerByNode = Eigen::Matrix<double, 4, 9>;

// Integrals over what a slave and a master face share.
struct Segment {
  CornerByNode D = CornerByNode::Zero();  // D_jk = int N_j N_k dA, both of the slave
  CornerByNode M = CornerByNode::Zero();  // M_jl = int N_j N_l dA, l of the master
  double area = 0;
};
// Multipliers are linear on faces of second order too: N_j of the corners alone, all of one sign,
// as a pressure is (the nodal forces of a uniform pressure on an 8-node face are not). N_k and N_l
// are those of the face, of straight sides: what the corners span is integrated over. Slave and
// master are integrated with the same points, so that rows of D and M have the same sum, and any
// linear field is carried over exactly, whatever the error of the quadrature; that is none for
// parallelograms and triangles and about 1e-10 for other quads down to a trapezoid of 1 to 5, 1e-7
// at 1 to 10, 1e-5 at 1 to 40. What is smaller than `sliver` times the smaller face is left out.
Segment integrate(const FlatFace& slave, const FlatFace& master, double sliver = 1e-12);

}  // namespace cbr
