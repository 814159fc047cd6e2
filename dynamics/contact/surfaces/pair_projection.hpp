// SPDX-License-Identifier: GPL-3.0-or-later
// Closest points of many faces to many nodes, in batches.
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

// Local coordinates of the closest point on the face extended beyond its edges; -1 to 1 on the
// face. NaN for triangles.
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

// Fills results[i] for pairs[i]: equal to project() within round-off, and independent of the other
// pairs. `before` may be missing if the node ends farther than `reach` in front of the face.
void project_pairs(const ContactSurface& master, const ContactBody& master_body,
                   const ContactBody& slave_body, std::span<const NodeAndFace> pairs, double reach,
                   std::vector<PairProjection>& results);

}  // namespace cbr
