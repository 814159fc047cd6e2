// SPDX-License-Identifier: GPL-3.0-or-later
// Which faces of two surfaces share some area and can touch in a step.
#pragma once

#include <vector>

#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"
#include "dynamics/contact/surfaces/mortar_segment.hpp"

namespace cbr {

struct MortarStep {
  const ContactSurface& slave;
  const ContactBody& slave_body;
  const ContactSurface& master;
  const ContactBody& master_body;
  const DetectionOptions& options;
  bool initial;
  double motion;  // largest of any node relative to the master's mean, in the step
  double reach;   // largest gap of interest for points
  double far;     // the same for faces: the support of a point on a curved surface
  Vector3 drift;  // mean motion of the master: boxes are swept by relative motion only
};
MortarStep mortar_step(const ContactSurface& slave, const ContactBody& slave_body,
                       const ContactSurface& master, const ContactBody& master_body, bool initial,
                       const DetectionOptions& options, const PairMemory& memory);

struct FacePair {
  Index slave_face = 0, master_face = 0;
  // outward, of the slave and the master face, when evaluated
  Vector3 normal, master_normal;
  double start_gap = 0, end_gap = 0;  // mean, along the normal
  bool on_the_way = false;            // shared area at the time when one crossed the other
  Segment segment;
};

// Ascending by slave face, then master face. The shared area is seen along the slave face's normal.
// Faces that touched in the last step are evaluated at the start of the step, others at its end.
// The prediction excludes the impulses of this step and would amplify the shortest waves.
std::vector<FacePair> find_face_pairs(const MortarStep& step, PairMemory& memory);

}  // namespace cbr
