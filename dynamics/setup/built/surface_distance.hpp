// SPDX-License-Identifier: GPL-3.0-or-later
// How far a point is from triangles, and two surfaces from each other.
#pragma once

#include <array>

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

using Triangle = std::array<Vector3, 3>;

// Nearest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5, by way of the
// edges).
Vector3 nearest_point(const Triangle& t, const Vector3& x);

// The surface's contact points where they are: `points` of all contact nodes of its body, shifted
// as a whole.
struct PlacedSurface {
  const ContactSurface& surface;
  const Points& points;  // m x 3
  Vector3 shift = Vector3::Zero();
};

// Least distance of the nodes of each from the faces of the other, and of sharp edges from edges,
// never below 0. Of large surfaces every k-th node and edge is looked at.
double distance_between(const PlacedSurface& a, const PlacedSurface& b);

}  // namespace cbr
