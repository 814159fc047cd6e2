// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that overlap before the first step.
#pragma once

#include "common/app/report.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Checks every pair of two bodies. Candidates are nodes of each within the other's extents,
// straight behind the nearest of its faces. Deeper than a face, and inside the other's mesh: a
// warning with pair, depth and node id. Contact would take such a node to be beyond a thin body.
// Less deep, between bodies at rest, which are not searched: recorded as the pair's initial
// overlap. Large surfaces: every k-th node.
void look_for_overlaps(const Scene& scene, BuiltScene& built, Report& report);

}  // namespace cbr
