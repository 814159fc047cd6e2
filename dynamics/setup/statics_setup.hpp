// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of statics: what they cannot have, and what they are run as.
#pragma once

#include "common/scene/scene.hpp"
#include "dynamics/run/simulation/time_plan.hpp"

namespace cbr {

// InputError: what statics, of the run or before it, do not know; what only statics know in a scene
// without them.
void check_statics(const Scene& scene);

// Loads without a history grow from 0 to what they are at the end.
Scene with_growing_loads(Scene scene);

// Load steps of time.step, or ten; fitted to the outputs.
TimePlan plan_statics(const TimeOptions& time, double every);

}  // namespace cbr
