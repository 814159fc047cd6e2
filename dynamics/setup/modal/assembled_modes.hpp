// SPDX-License-Identifier: GPL-3.0-or-later
// Modes of instances that ties and links join, large meshes among them in all of their dofs.
#pragma once

#include <vector>

#include "dynamics/setup/modal/modal_scene.hpp"

namespace cbr {

struct AssembledModes {
  Vector lambda;  // ascending; 0 of rigid motions
  Vector c;       // phi . C phi of each, from the bodies' own damping and dashpots
  std::vector<Matrix>
      shapes;  // of each body: of a mesh 3 N x modes, component axes, else n x modes
};

// Whether a mesh among the bodies has modes that are left out, so that its own do not tell those of
// all.
bool needs_assembly(const ModalScene& scene, const std::vector<Index>& bodies);

// The lowest `count`, by shift-invert Lanczos: with D = K - sigma M of the bodies apart and rows
// A x + S p = 0 of what joins them (m x n; S: m x m, compliance of springs and statics, p what they
// carry),
//   (K - sigma M)^-1 r = y - D^-1 A^T W^-1 A y,   y = D^-1 r,   W = A D^-1 A^T + S.
// Rows that others imply are dropped. InputError: more than most_rows of them, as W takes 8 bytes
// for each two. RunError: no convergence.
AssembledModes assembled_modes(const ModalScene& scene, const std::vector<Index>& bodies,
                               Index count, Index most_rows = 20000);

}  // namespace cbr
