// SPDX-License-Identifier: GPL-3.0-or-later
// Frequencies and mode shapes of a scene: of each instance as it is held and damped, or of
// instances that ties join.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/setup/modal/modal_scene.hpp"

namespace cbr {

struct InstanceModes {
  std::string instance;       // of joined ones "a+b"
  std::vector<Index> bodies;  // as ModalScene::bodies
  Vector frequency_hz;        // ascending; 0 of free rigid motions
  Vector damping_ratio;       // c / (2 omega); 0 of free rigid motions
  // of each of the bodies: its modal coordinates, n x modes; the mass of a mode is 1
  std::vector<Matrix> shapes;
};

struct SceneModes {
  std::unique_ptr<ModalScene> scene;
  std::vector<InstanceModes> instances;
};

// The lowest `n` (or all that there are) of each instance, or group of instances that ties join, in
// the scene's order. Loads and contact that is not tied are left out; the scene's `time` is not
// needed. RunError: no convergence.
SceneModes scene_modes(const Scene& scene, Index n, Report& report);

}  // namespace cbr
