// SPDX-License-Identifier: GPL-3.0-or-later
// The loads of a scene, on the bodies that they act on.
#pragma once

#include <vector>

#include "dynamics/motion/body.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// The plan of each body, with its loads; supports get what they carry. InputError: a set that is
// not there, or that cannot take this kind of load.
std::vector<BodyPlan> body_plans(const SceneIndex& index, BuiltScene& built);

}  // namespace cbr
