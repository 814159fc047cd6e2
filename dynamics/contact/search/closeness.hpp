// SPDX-License-Identifier: GPL-3.0-or-later
// Largest penetration of two surfaces, independent of the contact points.
#pragma once

#include <array>
#include <vector>

#include "dynamics/contact/search/detection.hpp"

namespace cbr {

struct Closeness {
  double depth = 0;       // of the deepest node, or of crossing edges
  double gap = HUGE_VAL;  // smallest, of nodes to faces or of edges; HUGE_VAL: beyond the reach
};

// A point on a face; -1: none.
struct Foot {
  Index face = -1;
  std::array<double, 4> weights{};  // of its corners
};

// State of the last call, which speeds up the next. Depths do not depend on it.
struct ClosenessMemory {
  PairMemory nodes, back, edges;      // their candidates
  std::vector<Foot> feet, back_feet;  // projection points: of slave nodes, of master nodes
};

// Depth and gap at ContactBody::end. Tests all nodes of each surface against all faces of the
// other, and sharp edges against edges. A node behind a face with a similar normal is on the other
// side of a thin body and is ignored. `reach`: largest depth and gap that are found. `known`: a
// depth found before; smaller depths are not searched. With `memory` of earlier calls `gap` is then
// incomplete too.
Closeness closeness(const ContactSurface& slave, const ContactBody& slave_body,
                    const ContactSurface& master, const ContactBody& master_body, double reach,
                    const DetectionOptions& options, double known, ClosenessMemory& memory);

}  // namespace cbr
