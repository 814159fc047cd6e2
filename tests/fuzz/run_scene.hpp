// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "common/scene/scene.hpp"

namespace cbr::fuzz {

// What cbr-reduce does with a scene, and the scene that it hands on. InputErrors and RunErrors as
// of run_reduce.
Scene reduced_scene(const std::string& file);

// What cbr-dyn does with a scene, for a few steps: whatever comes out of a run is finite.
void run_briefly(const Scene& scene);

}  // namespace cbr::fuzz
