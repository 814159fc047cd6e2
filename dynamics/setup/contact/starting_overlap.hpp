// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that are inside each other before the first step.
#pragma once

#include "common/app/report.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Looks at every pair of two bodies: nodes of either within the other's extents whose nearest
// point of the other's faces has them straight behind it. Deeper than a face, and in the other's
// body as its mesh says: a warning with pair, depth and node id, as contact takes such a node for
// one on the other side of a thin body. Less deep, between bodies at rest, which nobody searches:
// noted as the pair's initial overlap. Of large surfaces every k-th node is looked at.
void look_for_overlaps(const Scene& scene, BuiltScene& built, Report& report);

}  // namespace cbr
