// SPDX-License-Identifier: GPL-3.0-or-later
// Frequencies and mode shapes of a scene: of each constrained and damped instance, or of instances
// joined by ties.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/setup/modal/modal_scene.hpp"

namespace cbr {

struct InstanceModes {
  std::string instance;       // joined ones: "a+b"
  std::vector<Index> bodies;  // as in ModalScene::bodies
  Vector frequency_hz;        // ascending; 0 for free rigid motions
  Vector damping_ratio;       // c / (2 omega); 0 for free rigid motions
  // of each body: its modal coordinates, n x modes; unit modal mass
  std::vector<Matrix> shapes;
};

struct SceneModes {
  std::unique_ptr<ModalScene> scene;
  std::vector<InstanceModes> instances;
};

// The lowest `n` modes (or all) of each instance, or group of tied instances, in the scene's order.
// Without loads and contact that is not tied; `time` is not needed. RunError: no convergence.
SceneModes scene_modes(const Scene& scene, Index n, Report& report);

}  // namespace cbr
