// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "common/scene/scene.hpp"

namespace cbr::fuzz {

// Reduces like cbr-reduce; returns the scene for cbr-dyn. InputErrors and RunErrors as of
// run_reduce.
Scene reduced_scene(const std::string& file);

// Runs a scene like cbr-dyn for a few steps; requires finite results.
void run_briefly(const Scene& scene);

}  // namespace cbr::fuzz
