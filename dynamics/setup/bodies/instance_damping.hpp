// SPDX-License-Identifier: GPL-3.0-or-later
// The damping that a scene gives to an instance.
#pragma once

#include "dynamics/motion/damping.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Of its materials and its own. InputError: blocks of materials that are damped differently,
// contact with enforcement: nodal.
Damping damping_of(const SceneIndex& index, const Instance& instance);
// That of an instance which does not move in modes. InputError: damping that needs them.
MaterialDamping damping_without_modes(const SceneIndex& index, const Instance& instance);
void refuse_damping_of_scaled(const SceneIndex& index, const Instance& instance);

}  // namespace cbr
