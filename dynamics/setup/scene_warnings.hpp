// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene can hardly mean, told before its run.
#pragma once

#include "common/app/report.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Warns of pairs of contact surfaces that look away from each other, and of instances whose
// positions look like another unit of length than their mesh: apart by hundreds of their size
// without the speed to meet, or one in the other. Where they start counts.
void warn_of_odd_scenes(const Scene& scene, const BuiltScene& built, Report& report);

// Of a pulse between two steps, which would leave no trace: only a body that moves exactly takes a
// load as it is between its steps.
void warn_of_missed_loads(const SceneIndex& index, const BuiltScene& built, Report& report);

}  // namespace cbr
