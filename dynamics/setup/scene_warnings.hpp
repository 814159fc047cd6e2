// SPDX-License-Identifier: GPL-3.0-or-later
// Warnings of implausible scenes, before the run.
#pragma once

#include "common/app/report.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Warns of contact surfaces that face away from each other. Also of instances whose positions seem
// to have another unit of length than their mesh. They are hundreds of sizes apart without the
// speed to meet, or one is inside the other. Considers initial positions.
void warn_of_odd_scenes(const Scene& scene, const BuiltScene& built, Report& report);

// Warns of pulses between two steps, which would have no effect. Only bodies with exact motion
// include loads within a step.
void warn_of_missed_loads(const SceneIndex& index, const BuiltScene& built, Report& report);

}  // namespace cbr
