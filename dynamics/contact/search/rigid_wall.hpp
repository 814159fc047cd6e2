// SPDX-License-Identifier: GPL-3.0-or-later
// A rigid wall: plane, sphere or cylinder. It may be shifted, but does not turn.
#pragma once

#include <string>

#include "common/base/types.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/surfaces/motion_bound.hpp"

namespace cbr {

class RigidWall {
 public:
  explicit RigidWall(const WallOptions& options);

  const std::string& name() const { return options_.name; }
  // By how much it is shifted at the start and at the end of a step, and how fast at the end. All
  // calls below are about the wall where it was at first.
  struct Shift {
    Vector3 start = Vector3::Zero(), end = Vector3::Zero(), velocity = Vector3::Zero();
    Vector3 way() const { return end - start; }
  };
  void shift(const Shift& shift) { shift_ = shift; }
  const Shift& shift() const { return shift_; }
  double distance(const Vector3& x) const;  // signed; < 0: in the wall
  // unit, out of the wall at the point nearest to x; on an axis or at a centre: any
  Vector3 normal(const Vector3& x) const;
  // Nodes within the bound do not reach the wall before this time (0: not known to be free of it;
  // HUGE_VAL: never).
  double time_apart(const MotionBound& bound, double margin) const;
  // Where a straight way from x0 to x1 first gets into a solid sphere or cylinder: x0 when it
  // starts there, x1 when it does not, and for the other walls, where the normal at x1 will do.
  Vector3 entry(const Vector3& x0, const Vector3& x1) const;

 private:
  WallOptions options_;
  Shift shift_;
};

// Appends a point for each slave node that is near the wall or gets behind it in this step; its
// only term is the slave node. The normal is the wall's where the node is now when it touches, else
// at the predicted end of the step, or where the node came in when it has turned by more than 45
// degrees since then (through a ball within one step). Nodes that are behind the wall at the first
// step, or found there without having touched it, keep that overlap. Arguments as for detect();
// memory.face is 0 for nodes that touched in the last step.
void detect_wall(const ContactSurface& slave, const ContactBody& slave_body, const RigidWall& wall,
                 bool initial, PairMemory& memory, ContactList& list);

}  // namespace cbr
