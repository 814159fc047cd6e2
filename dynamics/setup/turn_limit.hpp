// SPDX-License-Identifier: GPL-3.0-or-later
// How far linear bodies may turn.
#pragma once

#include <vector>

#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Per instance, rad: beyond it a linear one is wrong. 5 degrees; less of a tall one that stands or
// hangs under gravity, whose weight loses 5 % of its moment before that. HUGE_VAL: it turns, or
// cannot turn.
std::vector<double> turn_limits(const SceneIndex& index, const BuiltScene& built);

}  // namespace cbr
