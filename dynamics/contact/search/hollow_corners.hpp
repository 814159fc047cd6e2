// SPDX-License-Identifier: GPL-3.0-or-later
// Faces that constrain a node together: docs/theory.md, "Hollow corners".
#pragma once

#include <span>
#include <vector>

#include "dynamics/contact/search/detection.hpp"

namespace cbr {

// Faces and options of a search.
struct DetectionStep {
  const ContactSurface& master;
  const ContactBody& master_body;
  const DetectionOptions& options;
  double reach;  // gaps up to this are candidates
};

// A face that a node meets.
struct FaceHit {
  Projection end;
  double start_gap = 0, end_gap = 0;  // relative to the closed state of an adjusted gap
  // Time at which the node crosses the face, as a fraction of the step. Not above 0: depth at the
  // start, relative to the face size. A node enters a convex body by the face that it crosses last.
  double entry = 0;
  bool entry_is_rough = false;  // by linear gaps, without solving for the time
  // Distance of the node outside the face at the start, relative to the face size; not above 0:
  // over it. Of a rising face: that of the foot of the slope beside the node
  double outside = 0;
  bool over_now = false, over_at_end = false, nearly_over = false;
  bool right_over_at_end = false;  // within the tolerance of untouched faces
  bool same = false;               // the node touched this face in the last step
  // normal similar to that of the face touched in the last step
  bool follows = false;
  Index face = 0;
};

// State of a node from earlier steps.
struct SlaveNode {
  Index slot = 0;
  Vector3 start, end;
  // touched in the last step, -1: none; `normal`: its normal at the start of this step
  Index face = -1;
  Vector3 normal = Vector3::Zero();
  // of the last touched face since the bodies were apart; zero: none
  Vector3 known_normal = Vector3::Zero();
  // further faces touched in the last step, -1 after the last
  std::span<const Index> further;
  double lift = 0;  // an adjusted initial gap, interference or clearance
};

// Uses the normal and projection point of the start of the step for a touching node. The prediction
// excludes the impulses of this step, so that it is wrong by their effect, mostly for the shortest
// waves. Normals that follow the prediction amplify them. Two balls pressed together at 0.9 of the
// critical step had a hundred times their energy after one Hertz contact.
void touch_where_it_is(const Projection& now, const FaceCorners& end, const Vector3& x_end,
                       Projection& point);

// Whether `face` rises from the face `from`.
bool rises_from(const ContactSurface& master, Index face, Index from);

// Reorders `hits`, which are sorted best first: those that constrain the node come first. Returns
// their number.
std::size_t choose_holding(const DetectionStep& step, const SlaveNode& node,
                           std::vector<FaceHit>& hits);

}  // namespace cbr
