// SPDX-License-Identifier: GPL-3.0-or-later
// Distance of a point from triangles, and of two surfaces.
#pragma once

#include <array>

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

using Triangle = std::array<Vector3, 3>;

// Nearest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5, by its edges).
Vector3 nearest_point(const Triangle& t, const Vector3& x);

// Contact points of the surface in place: `points` of all contact nodes of its body, with a common
// shift.
struct PlacedSurface {
  const ContactSurface& surface;
  const Points& points;  // m x 3
  Vector3 shift = Vector3::Zero();
};

// Least distance of nodes of each from faces of the other, and of sharp edges from edges; never
// below 0. Large surfaces: a subset of nodes and edges.
double distance_between(const PlacedSurface& a, const PlacedSurface& b);

}  // namespace cbr
