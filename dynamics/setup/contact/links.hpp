// SPDX-License-Identifier: GPL-3.0-or-later
// What links the reference points of instances: pairs of surfaces without faces, and joints.
#pragma once

#include <map>

#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// A pair of surfaces without faces for the translations that each link holds, and one for its
// rotations; the same for those that have springs, and for the masses of points, each with a joint
// behind the bodies; and one for what keeps a point's nodes rigid. contact_of_instance: places in
// Simulation::contact_nodes.
void add_links(const SceneIndex& index, const std::map<Index, Index>& contact_of_instance,
               BuiltScene& built);

}  // namespace cbr
