// SPDX-License-Identifier: GPL-3.0-or-later
// How a body rests when its supports are moved: the shapes that uneven supports move it in, and
// that reactions are found with.
#pragma once

#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "dynamics/motion/driven_motion.hpp"

namespace cbr {

// Column j: the coordinates (Body::coordinates(), component axes) of equilibrium under forces on
// the supports alone, which are moved in the j-th way. So K psi is 0 but at the supports.
struct SupportShapes {
  Matrix psi;        // n x m
  Matrix inertia;    // M psi, n x m
  Matrix stiffness;  // psi^T K psi, m x m
  Matrix momentum;   // R^T M psi, 6 x m: R translations, and rotations about the centre of mass

  Matrix mass() const { return psi.transpose() * inertia; }
};

// A set whose reactions are asked for: six shapes that move it, along x, y, z and about them.
struct ReactionSet {
  std::string name;                 // of the set
  Vector3 point = Vector3::Zero();  // scene axes, that rotations and the moment are about
};

// What a SupportedBody does with its supports.
struct SupportPlan {
  SupportShapes shapes;
  std::vector<DrivenAxis> drives;  // of the first shapes
  std::vector<ReactionSet> sets;   // of the others, six each
  Index n_modal = 0;               // coordinates before those of the nodes
  Matrix3 T = Matrix3::Identity();
  double mass = 0;
  Matrix3 inertia = Matrix3::Zero();  // about the centre of mass, component axes
  bool has_inertia = true;  // false in statics, where supports have places and no velocities
  bool waits = false;       // statics come first, see StaticsAbility::start_motion()
};

}  // namespace cbr
