// SPDX-License-Identifier: GPL-3.0-or-later
// Rows for output.stress and histories of interior sets of superelements.
#pragma once

#include "common/scene/scene.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Fills simulation.watches and scans. InputError: no recovery data; a missing set or element; a
// body with large rotation.
void add_stress(const SceneIndex& index, BuiltScene& built);

// Fills rows and reference of the monitor of an interior set. InputError as above.
void watch_inside(const SceneIndex& index, const SurfaceName& set, const BuiltScene::OfInstance& of,
                  Monitor& monitor);

}  // namespace cbr
