// SPDX-License-Identifier: GPL-3.0-or-later
// Closest points of many faces to many nodes, several at a time.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// A node of the slave's body that may meet a face of the master.
struct NodeAndFace {
  Index node = 0, face = 0;
};

// The face's coordinates of the nearest point of the face and of what lies beyond its edges, from
// -1 to 1 on the face; not a number for triangles.
struct FacePlace {
  double xi = std::numeric_limits<double>::quiet_NaN();
  double eta = std::numeric_limits<double>::quiet_NaN();
};

struct AtTime : Projection {
  FacePlace place;
};

struct PairProjection {
  AtTime before, end;  // at the start and at the end of the step
};

// Fills results[i] for pairs[i], as project() does but for round-off. What is found of a pair does
// not depend on the others. Where the node ends farther in front of the face than `reach`,
// `before` may be missing.
void project_pairs(const ContactSurface& master, const ContactBody& master_body,
                   const ContactBody& slave_body, std::span<const NodeAndFace> pairs, double reach,
                   std::vector<PairProjection>& results);

}  // namespace cbr
