// SPDX-License-Identifier: GPL-3.0-or-later
// How deep two surfaces are in each other, whatever points contact tests.
#pragma once

#include "dynamics/contact/search/detection.hpp"

namespace cbr {

struct Closeness {
  double depth = 0;       // of the deepest node, or of edges that cross
  double gap = HUGE_VAL;  // of the nearest node to a face, or of edges; HUGE_VAL: beyond the reach
};

// All nodes of both surfaces against all faces of the other, and sharp edges against edges, where
// the bodies are, start and end of the step being the same. Nodes that look the same way as the
// face that they are behind are on the other side of a thin body. `reach`: what is deeper or
// farther is not seen.
Closeness closeness(const ContactSurface& slave, const ContactBody& slave_body,
                    const ContactSurface& master, const ContactBody& master_body, double reach,
                    const DetectionOptions& options);

}  // namespace cbr
