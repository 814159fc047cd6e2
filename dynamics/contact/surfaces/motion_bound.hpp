// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of the motion of nodes.
#pragma once

#include "common/base/types.hpp"

namespace cbr {

// Bound of the positions of a set of nodes at a time t >= 0 from now, without contact. On each axis
// between lower + lower_speed t - spread and upper + upper_speed t + spread, spread = growth t +
// acceleration t^2 / 2.
struct MotionBound {
  Vector3 lower, upper, lower_speed, upper_speed, growth, acceleration;
};

}  // namespace cbr
