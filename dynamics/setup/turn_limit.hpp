// SPDX-License-Identifier: GPL-3.0-or-later
// Limits of the rotation of linear bodies.
#pragma once

#include <vector>

#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Per instance, rad: the rotation beyond which a linear model is wrong. 5 degrees; less for a tall
// body that stands or hangs under gravity and loses 5 % of its restoring moment earlier. HUGE_VAL:
// it has large rotation, or does not allow it.
std::vector<double> turn_limits(const SceneIndex& index, const BuiltScene& built);

}  // namespace cbr
