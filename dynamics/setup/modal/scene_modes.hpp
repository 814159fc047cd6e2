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

struct AssembledModes {
  Vector lambda;  // ascending; 0 for rigid motions
  Vector c;       // phi . C phi of each mode, by the bodies' own damping and dashpots
  std::vector<Matrix>
      shapes;  // of each body: of a mesh 3 N x modes, component axes, else n x modes
};

// How modes are found. dense: all of them, in dense matrices, without meshes in all of their dofs.
// size: dense where that costs less.
enum class JoinedBy { size, dense, lanczos };

// The lowest `count` of bodies that ties join. Ties give rows A x + S p = 0 (m x n; S: m x m,
// compliance of springs and residual compliance; p: tie forces). Shift-invert Lanczos with D = K -
// sigma M of the separate bodies:
//   (K - sigma M)^-1 r = y - D^-1 A^T W^-1 A y,   y = D^-1 r,   W = A D^-1 A^T + S.
// W is sparse, with a dense block for the rows of each body. InputError: a mesh has more than
// most_rows of them. RunError: no convergence.
AssembledModes assembled_modes(const ModalScene& scene, const std::vector<Index>& bodies,
                               Index count, const Progress& progress = {},
                               JoinedBy by = JoinedBy::size, Index most_rows = 20000);

}  // namespace cbr
