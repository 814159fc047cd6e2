// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of the motion of nodes.
#pragma once

#include <cmath>

#include "common/base/types.hpp"

namespace cbr {

// Bound of the positions of a set of nodes at a time t >= 0 from now, without contact. On each axis
// between lower + lower_speed t - spread and upper + upper_speed t + spread, spread = growth t +
// acceleration t^2 / 2.
struct MotionBound {
  Vector3 lower, upper, lower_speed, upper_speed, growth, acceleration;
};

// The bound a time t >= 0 later.
inline MotionBound later(const MotionBound& bound, double t) {
  MotionBound then = bound;
  const Vector3 spread = bound.growth * t + bound.acceleration * (0.5 * t * t);
  then.lower += bound.lower_speed * t - spread;
  then.upper += bound.upper_speed * t + spread;
  then.growth += bound.acceleration * t;
  return then;
}

// First time at which gap + speed t - spread t - acceleration t^2 / 2 reaches 0.
inline double first_root(double gap, double speed, double spread, double acceleration) {
  if (!(gap > 0)) return 0;
  const double closing = spread - speed;
  if (!(acceleration > 0)) return closing > 0 ? gap / closing : HUGE_VAL;
  return 2 * gap / (closing + std::sqrt(closing * closing + 2 * acceleration * gap));
}

}  // namespace cbr
