// SPDX-License-Identifier: GPL-3.0-or-later
// Steps of build(), each in the file of its name.
#pragma once

#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// loads_setup.cpp: the plan of each body, with its loads; supports get their reaction sets.
// InputError: a missing set, or a set that does not allow this kind of load.
std::vector<BodyPlan> body_plans(const SceneIndex& index, BuiltScene& built);

// turn_limit.cpp: per instance, rad: the rotation beyond which a linear model is wrong. 5 degrees;
// less for a tall body that stands or hangs under gravity and loses 5 % of its restoring moment
// earlier. HUGE_VAL: it has large rotation, or does not allow it.
std::vector<double> turn_limits(const SceneIndex& index, const BuiltScene& built);
// After contact and turn_limit: a line on the first instance that its velocity or its weight
// carries onto a plane wall or another body beside its centre of mass, so that it turns beyond its
// limit in the run. Empty: none does.
std::string first_turning_strike(const SceneIndex& index, const BuiltScene& built);

// output_setup.cpp

// After contact and the bodies. InputError: a missing set, or as below.
void add_monitors(const SceneIndex& index, BuiltScene& built);

// Fills simulation.watches and scans. InputError: no recovery data; a missing set or element; a
// body with large rotation.
void add_stress(const SceneIndex& index, BuiltScene& built);

// scene_warnings.cpp

// Warns of contact surfaces that face away from each other. Also of instances whose positions seem
// to have another unit of length than their mesh. They are hundreds of sizes apart without the
// speed to meet, or one is inside the other. Considers initial positions.
void warn_of_odd_scenes(const Scene& scene, const BuiltScene& built, Report& report);

// Warns of pulses between two steps, which would have no effect. Only bodies with exact motion
// include loads within a step.
void warn_of_missed_loads(const SceneIndex& index, const BuiltScene& built, Report& report);

}  // namespace cbr
