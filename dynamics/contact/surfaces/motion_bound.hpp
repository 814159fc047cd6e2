// SPDX-License-Identifier: GPL-3.0-or-later
// Where nodes can get to.
#pragma once

#include "common/base/types.hpp"

namespace cbr {

// Where a set of nodes can be a time t >= 0 from now, without contact: for each axis between lower
// + lower_speed t - spread and upper + upper_speed t + spread, spread = growth t + acceleration t^2
// / 2.
struct MotionBound {
  Vector3 lower, upper, lower_speed, upper_speed, growth, acceleration;
};

}  // namespace cbr
