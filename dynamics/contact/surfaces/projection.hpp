// SPDX-License-Identifier: GPL-3.0-or-later
// Closest point of a face to a point: pure geometry.
#pragma once

#include <array>

#include "common/base/types.hpp"

namespace cbr {

using FaceCorners = std::array<Vector3, 4>;  // a triangle repeats its third corner

struct Projection {
  // of the corners at the projection point: >= 0, sum 1; a triangle's fourth is 0
  std::array<double, 4> weights{};
  // unit, of the face at the projection point; zero for a face without area
  Vector3 normal = Vector3::Zero();
  double distance = 0;  // normal . (x - projection point), signed
  // distance of the unclamped projection point outside the face, relative to its size; <= 0: inside
  double outside = 0;
};

// Orthogonal projection, clamped to the face. Bilinear quads by Newton's method with backtracking,
// Gauss-Newton where the Hessian is not positive definite. Never NaN for finite input.
Projection project(const FaceCorners& corners, bool triangle, const Vector3& x);

}  // namespace cbr
