// SPDX-License-Identifier: GPL-3.0-or-later
// Modes of instances joined by ties and links, with large meshes in all of their dofs.
#pragma once

#include <vector>

#include "dynamics/setup/modal/modal_scene.hpp"

namespace cbr {

struct AssembledModes {
  Vector lambda;  // ascending; 0 for rigid motions
  Vector c;       // phi . C phi of each mode, by the bodies' own damping and dashpots
  std::vector<Matrix>
      shapes;  // of each body: of a mesh 3 N x modes, component axes, else n x modes
};

// Whether a mesh among the bodies omits modes, so that its own do not give those of all.
bool needs_assembly(const ModalScene& scene, const std::vector<Index>& bodies);

// The lowest `count`, by shift-invert Lanczos with D = K - sigma M of the separate bodies. Ties
// give rows A x + S p = 0 (m x n; S: m x m, compliance of springs and residual compliance; p: tie
// forces).
//   (K - sigma M)^-1 r = y - D^-1 A^T W^-1 A y,   y = D^-1 r,   W = A D^-1 A^T + S.
// Dependent rows are dropped. InputError: more than most_rows of them, as W takes 8 bytes per two.
// RunError: no convergence.
AssembledModes assembled_modes(const ModalScene& scene, const std::vector<Index>& bodies,
                               Index count, Index most_rows = 20000);

}  // namespace cbr
