// SPDX-License-Identifier: GPL-3.0-or-later
// Which of the faces that a node meets hold it together: docs/theory.md, "Hollow corners".
#pragma once

#include <span>
#include <vector>

#include "dynamics/contact/search/detection.hpp"

namespace cbr {

// What a search knows of the faces.
struct DetectionStep {
  const ContactSurface& master;
  const ContactBody& master_body;
  const DetectionOptions& options;
  double reach;  // gaps up to this are candidates
};

// A face that a node meets.
struct FaceHit {
  Projection end;
  double start_gap = 0, end_gap = 0;  // distances, counted from where an adjusted gap is closed
  // When the node went through the face, as a share of the step; not above 0: it was behind it at
  // the start, by this share of the face's size. The last face that a node goes through is the one
  // by which it enters a convex body.
  double entry = 0;
  bool entry_is_rough = false;  // taken as if face and node moved by little
  // How far the node is off the face now, as a share of the face's size, not above 0: over it; of a
  // face that rises from another: the foot of the slope beside the node
  double outside = 0;
  bool over_now = false, over_at_end = false, nearly_over = false;
  bool right_over_at_end = false;  // not only within the tolerance of what was touched before
  bool same = false;               // it is the face that the node touched in the last step
  // looks the same way as the face that the node touched in the last step
  bool follows = false;
  Index face = 0;
};

// What is known of a node from the steps before.
struct SlaveNode {
  Index slot = 0;
  Vector3 start, end;
  // touched in the last step, -1: none; at the start of this one it looks along `normal`
  Index face = -1;
  Vector3 normal = Vector3::Zero();
  // of the face touched last since the bodies were apart; zero: none
  Vector3 known_normal = Vector3::Zero();
  // more faces that were touched in the last step, -1 behind the last
  std::span<const Index> further;
  double lift = 0;  // an adjusted gap
};

// A node that touches is held along the normal and at the foot that it has now. The prediction
// knows no impulses of this step: it is off by what they do, most of all for the shortest waves,
// and normals that lean with it feed them (two balls pressed together at 0.9 of the critical step
// had a hundred times their energy after one Hertz contact).
void touch_where_it_is(const Projection& now, const FaceCorners& end, const Vector3& x_end,
                       Projection& point);

// Whether `face` is one of those that rise from the face `from`.
bool rises_from(const ContactSurface& master, Index face, Index from);

// Of what was found, best first: the hits that hold the node come first then; returns how many.
std::size_t choose_holding(const DetectionStep& step, const SlaveNode& node,
                           std::vector<FaceHit>& hits);

}  // namespace cbr
