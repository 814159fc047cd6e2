// SPDX-License-Identifier: GPL-3.0-or-later
// Loads of a scene, on their bodies.
#pragma once

#include <vector>

#include "dynamics/motion/body.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// The plan of each body, with its loads; supports get their reaction sets. InputError: a missing
// set, or a set that does not allow this kind of load.
std::vector<BodyPlan> body_plans(const SceneIndex& index, BuiltScene& built);

}  // namespace cbr
