// SPDX-License-Identifier: GPL-3.0-or-later
// Damping of an instance by the scene.
#pragma once

#include "dynamics/motion/damping.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// By materials and by the instance. InputError: blocks with different damping, or contact with
// enforcement: nodal.
Damping damping_of(const SceneIndex& index, const Instance& instance);
// For an instance without modal coordinates. InputError: damping that needs modes.
MaterialDamping damping_without_modes(const SceneIndex& index, const Instance& instance);

}  // namespace cbr
