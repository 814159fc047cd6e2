// SPDX-License-Identifier: GPL-3.0-or-later
// Edges of a surface, and which of them are sharp.
#pragma once

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// Fills `edges` and `ridge`; `points` are the undeformed contact nodes of the body.
void fill_edges(ContactSurface& surface, const Points& points);

// Unit vectors at a point of an edge: along it, the outward normals of the faces beside it, and
// where these lead away from the edge. Beside an open edge the body is taken to be at right angles.
struct EdgeWedge {
  Vector3 direction;
  std::array<Vector3, 2> normal, inward;
  // The middle of the two normals, unit.
  Vector3 outward() const { return (normal[0] + normal[1]).normalized(); }
};
EdgeWedge wedge_at(const ContactSurface& surface, const SurfaceEdge& edge, const Points& points);

}  // namespace cbr
