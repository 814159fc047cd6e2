// SPDX-License-Identifier: GPL-3.0-or-later
// A rigid wall: plane, sphere or cylinder. It may translate, but does not rotate.
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
  // Translation at the start and the end of a step, velocity at the end, and translation over as
  // long a step before. All calls below refer to the initial position of the wall.
  struct Shift {
    Vector3 start = Vector3::Zero(), end = Vector3::Zero(), velocity = Vector3::Zero(),
            way_before = Vector3::Zero();
    Vector3 way() const { return end - start; }
  };
  bool moves() const { return options_.motion != SupportMotion::none; }  // else it does no work
  void shift(const Shift& shift) { shift_ = shift; }
  const Shift& shift() const { return shift_; }
  bool is_plane() const { return options_.kind == WallOptions::Kind::plane; }
  // By how much the wall bulges through a flat face of this size between its nodes, which touch it;
  // HUGE_VAL: it passes between them. 0: a plane, or bodies are inside.
  double bulge(double size) const;
  double distance(const Vector3& x) const;  // signed; < 0: in the wall
  // unit, out of the wall at the point nearest to x; arbitrary on an axis or at a centre
  Vector3 normal(const Vector3& x) const;
  // Nodes within the bound do not reach the wall before this time. 0: they may touch now; HUGE_VAL:
  // never.
  double time_apart(const MotionBound& bound, double margin) const;
  // Where the straight path from x0 to x1 enters a solid sphere or cylinder. x0 if it starts
  // inside, x1 if it does not enter; x1 for other walls, whose normal at x1 is valid.
  Vector3 entry(const Vector3& x0, const Vector3& x1) const;

 private:
  WallOptions options_;
  Shift shift_;
};

// Appends a point for each slave node that is near the wall or penetrates it in this step; its only
// term is the slave node. The normal of a touching node is the wall's at the start of the step,
// else at the predicted end. If it has rotated by more than 45 degrees since the entry (through a
// ball in one step), it is that at the entry. Nodes that penetrate at the first step, or later
// without having touched, keep that overlap. Arguments as for detect(); memory.face is 0 for nodes
// that touched in the last step. standing_reach above 0, of planes: the nodes that have a point
// stay the same until another one comes near, and then all within this length beyond the reach have
// one.
void detect_wall(const ContactSurface& slave, const ContactBody& slave_body, const RigidWall& wall,
                 bool initial, double standing_reach, PairMemory& memory, ContactList& list);

}  // namespace cbr
