// SPDX-License-Identifier: GPL-3.0-or-later
// The motion that boundary conditions give the supports of an instance.
#pragma once

#include "dynamics/motion/driven_motion.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Empty: supports at rest, or none. InputError: sets that are held along one axis and move unlike
// each other along it.
DrivenMotion support_motion(const SceneIndex& index, const Instance& instance);

}  // namespace cbr
