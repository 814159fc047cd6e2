// SPDX-License-Identifier: GPL-3.0-or-later
// Faces that a node cannot be over at any time of a step, told without looking for the closest point.
#pragma once

#include <vector>

#include "dynamics/contact/contact_surface.hpp"

namespace cbr {

// Of a quad whose corners move on straight lines: the two pairs of planes between which everything over it is. Triangles have none.
struct FaceSlab {
  bool is_known = false;
  Vector3 start_centre, end_centre;
  std::array<Vector3, 2> across;          // dual to the sides' half differences a and b: across . a = 1, across . b = 0
  std::array<double, 2> limit{}, lean{};  // a node with |across . (x - centre)| > limit + lean |x - centre| is not over the face
};

// `edge`: what counts as over the face although it is off it, as a share of its size.
FaceSlab face_slab(const FaceCorners& start, const FaceCorners& end, bool triangle, double edge);

// Whether a node that moves from `start` to `end` in the step is beside the face all the time. Never true for one that is over it.
bool is_beside(const FaceSlab& slab, const Vector3& start, const Vector3& end);

}  // namespace cbr
