// SPDX-License-Identifier: GPL-3.0-or-later
// Static scenes: unsupported keys, and the scene of the run.
#pragma once

#include "common/scene/scene.hpp"
#include "dynamics/run/simulation/time_plan.hpp"

namespace cbr {

// InputError: keys that statics do not support, in the run or a preload; keys of statics in a scene
// without them.
void check_statics(const Scene& scene);

// Lets loads without a history grow from 0 to their value at the end.
Scene with_growing_loads(Scene scene);

// Load steps of time.step, or ten; adjusted to the outputs.
TimePlan plan_statics(const TimeOptions& time, double every);

}  // namespace cbr
