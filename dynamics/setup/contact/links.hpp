// SPDX-License-Identifier: GPL-3.0-or-later
// Links between reference points of instances: pairs of surfaces without faces, and joints.
#pragma once

#include <map>

#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Adds pairs of surfaces without faces: for each link one for its constrained translations and one
// for its rotations. Springs, and masses of points, get the same, each with a joint after the
// bodies. A rigid point has one for its nodes. contact_of_instance: indices in
// Simulation::contact_nodes.
void add_links(const SceneIndex& index, const std::map<Index, Index>& contact_of_instance,
               BuiltScene& built);

}  // namespace cbr
