// SPDX-License-Identifier: GPL-3.0-or-later
// The damping that a scene gives to an instance.
#pragma once

#include "dynamics/motion/body.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Of its materials and its own. InputError: blocks of materials that are damped differently,
// contact with enforcement: nodal.
Damping damping_of(const SceneIndex& index, const Instance& instance);
// Gives it to the instance's body. InputError, with the instance's line: damping that such a body
// cannot have.
void damp(const Instance& instance, const Damping& damping, Body& body);

}  // namespace cbr
