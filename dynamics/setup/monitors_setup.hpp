// SPDX-License-Identifier: GPL-3.0-or-later
// output.history: the sets and points whose motion and forces are recorded at each output.
#pragma once

#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// After contact and the bodies. InputError: a missing set.
void add_monitors(const SceneIndex& index, BuiltScene& built);

}  // namespace cbr
