// SPDX-License-Identifier: GPL-3.0-or-later
// What contact knows of the bodies: points now and predicted, faces between them, the response to impulses.
#pragma once

#include <string>
#include <vector>

#include "common/types.hpp"
#include "dynamics/contact/node_response.hpp"
#include "dynamics/contact/projection.hpp"

namespace cbr {

// All contact nodes of one body; m nodes, numbered 0 .. m - 1.
struct ContactBody {
  Points start, end;      // m x 3: positions now and predicted for the end of the step
  Points impulses;        // m x 3: of this step, filled by the enforcement; without friction
  Points friction;        // m x 3: of this step, of friction
  NodeResponse response;  // for the step length response_h
  double response_h = 0;
};

struct ContactSurface {
  std::string name;          // INSTANCE.SURFACE, for messages
  Index body = 0;            // index into the contact bodies
  std::vector<Index> nodes;  // of the faces, ascending, contact nodes of the body
  IndexTable faces;          // f x 4, contact nodes of the body; a triangle repeats its last
  Vector sizes;              // f, sqrt of the undeformed area: the face's length scale
  double size = 0;           // their mean
  Vector areas;              // of `nodes`: their share of the undeformed area, a face's shared by its corners
};

// Sizes and areas; `points` are the undeformed contact nodes of the body.
void fill_sizes(ContactSurface& surface, const Points& points);

inline bool is_triangle(const ContactSurface& surface, Index face) { return surface.faces(face, 2) == surface.faces(face, 3); }

FaceCorners corners(const ContactSurface& surface, Index face, const Points& points);

}  // namespace cbr
