// SPDX-License-Identifier: GPL-3.0-or-later
// How deep two surfaces are in each other, whatever points contact tests.
#pragma once

#include <array>
#include <vector>

#include "dynamics/contact/search/detection.hpp"

namespace cbr {

struct Closeness {
  double depth = 0;       // of the deepest node, or of edges that cross
  double gap = HUGE_VAL;  // of the nearest node to a face, or of edges; HUGE_VAL: beyond the reach
};

// A point of a face; -1: none.
struct Foot {
  Index face = -1;
  std::array<double, 4> weights{};  // of its corners
};

// Of the last look, for the next. No depth depends on it.
struct ClosenessMemory {
  PairMemory nodes, back, edges;      // their candidates
  std::vector<Foot> feet, back_feet;  // of the slave's nodes, and of the master's
};

// All nodes of both surfaces against all faces of the other, and sharp edges against edges, where
// the bodies are, start and end of the step being the same. Nodes that look the same way as the
// face that they are behind are on the other side of a thin body. `reach`: what is deeper or
// farther is not seen. `known`: a depth that there is already; less is not looked for, and with a
// memory of earlier looks `gap` is not either.
Closeness closeness(const ContactSurface& slave, const ContactBody& slave_body,
                    const ContactSurface& master, const ContactBody& master_body, double reach,
                    const DetectionOptions& options, double known, ClosenessMemory& memory);

}  // namespace cbr
