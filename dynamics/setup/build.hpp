// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup: scene to bodies, contact and steps.
//
// From a scene to a simulation that is ready to run.
#pragma once

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Reads superelements and meshes, in phases "read" and "setup" of the report. InputError: a missing
// or stale superelement (with the command to run), missing surfaces, or an unsupported combination.
BuiltScene build(const Scene& scene, Report& report, const BuildOptions& options = {});
// The scene with `rotations: auto` resolved as in build().
Scene with_rotations(Scene scene, const BuildOptions& options);

}  // namespace cbr
