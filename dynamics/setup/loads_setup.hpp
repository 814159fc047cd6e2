// SPDX-License-Identifier: GPL-3.0-or-later
// The loads of a scene, on the bodies that they act on.
#pragma once

#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Gives each body its loads, and supports what they carry. InputError: a set that is not there, or
// that cannot take this kind of load.
void add_loads(const SceneIndex& index, BuiltScene& built);

}  // namespace cbr
