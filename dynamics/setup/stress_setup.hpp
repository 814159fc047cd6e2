// SPDX-License-Identifier: GPL-3.0-or-later
// output.stress and histories of sets inside superelements: what the recorder evaluates.
#pragma once

#include "common/scene/scene.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Fills simulation.watches and scans. InputError: no recovery data; a set or element that is not
// there; a body that turns.
void add_stress(const SceneIndex& index, BuiltScene& built);

// Of a set that the superelement recovers: rows and reference of the monitor. InputError as above.
void watch_inside(const SceneIndex& index, const SurfaceName& set, const BuiltScene::OfInstance& of,
                  Monitor& monitor);

}  // namespace cbr
