// SPDX-License-Identifier: GPL-3.0-or-later
// A rigid wall that does not move: plane, sphere or cylinder.
#pragma once

#include <string>

#include "common/scene.hpp"
#include "common/types.hpp"
#include "dynamics/bodies/body.hpp"

namespace cbr {

class RigidWall {
 public:
  explicit RigidWall(const WallOptions& options);

  const std::string& name() const { return options_.name; }
  double distance(const Vector3& x) const;  // signed; < 0: in the wall
  Vector3 normal(const Vector3& x) const;   // unit, out of the wall at the point nearest to x; on an axis or at a centre: any
  // Nodes within the bound do not reach the wall before this time (0: not known to be free of it; HUGE_VAL: never).
  double time_apart(const MotionBound& bound, double margin) const;

 private:
  WallOptions options_;
};

}  // namespace cbr
