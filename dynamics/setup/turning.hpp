// SPDX-License-Identifier: GPL-3.0-or-later
// Which scenes and instances can turn by large angles (time.rotations: large).
#pragma once

#include "dynamics/setup/component_model.hpp"

namespace cbr {

// InputError, one line that names what does not turn: before any file is read; of an instance and what it is made of.
// `rotations: small` refuses angular velocities alone.
void refuse_what_does_not_turn(const Scene& scene);
void require_turning(const SceneIndex& index, const Instance& instance, const ReducedComponent& component);

}  // namespace cbr
