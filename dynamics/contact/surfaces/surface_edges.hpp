// SPDX-License-Identifier: GPL-3.0-or-later
// Edges of a surface, and which are sharp.
#pragma once

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// Fills `edges` and `ridge`; `points` are the undeformed contact nodes of the body.
void fill_edges(ContactSurface& surface, const Points& points);

// Unit vectors at a point of an edge: its direction, the outward normals of the adjacent faces, and
// the directions into these faces. At an open edge the missing face is assumed at a right angle.
struct EdgeWedge {
  Vector3 direction;
  std::array<Vector3, 2> normal, inward;
  // Normalised mean of the two normals.
  Vector3 outward() const { return (normal[0] + normal[1]).normalized(); }
};
EdgeWedge wedge_at(const ContactSurface& surface, const SurfaceEdge& edge, const Points& points);

}  // namespace cbr
