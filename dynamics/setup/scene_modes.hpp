// SPDX-License-Identifier: GPL-3.0-or-later
// Frequencies of the instances of a scene, as they are held and damped.
#pragma once

#include <string>
#include <vector>

#include "common/report.hpp"
#include "common/scene.hpp"

namespace cbr {

struct InstanceModes {
  std::string instance;
  Vector frequency_hz;   // ascending; 0 of free rigid motions
  Vector damping_ratio;  // c / (2 omega); 0 of free rigid motions
};

// The lowest `n` (or all that there are) of each instance by itself, in the scene's order. Contact and loads are left out; the
// scene's `time` is not needed. InputError: tied surfaces, shells that act. RunError: no convergence.
std::vector<InstanceModes> scene_modes(const Scene& scene, Index n, Report& report);

}  // namespace cbr
