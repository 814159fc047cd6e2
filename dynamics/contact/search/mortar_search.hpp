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
  double motion;  // largest of any node against the master's mean, in the step
  double reach;   // points with gaps up to this are of interest
  double far;     // faces up to this: the support of a point on a curved surface
  Vector3 drift;  // mean motion of the master: boxes are swept by relative motion only
};
MortarStep mortar_step(const ContactSurface& slave, const ContactBody& slave_body,
                       const ContactSurface& master, const ContactBody& master_body, bool initial,
                       const DetectionOptions& options, const PairMemory& memory);

struct FacePair {
  Index slave_face = 0, master_face = 0;
  // of the slave and the master face, outward, as they are looked at
  Vector3 normal, master_normal;
  double start_gap = 0, end_gap = 0;  // mean, along the normal
  bool on_the_way = false;            // what they share is that of where one went through the other
  Segment segment;
};

// Ascending by slave face, then master face. What is shared is seen along the slave
// face's normal: at the start of the step for faces that touched in the last one (the prediction
// knows no impulses of this step and would feed the shortest waves), at the end for others.
std::vector<FacePair> find_face_pairs(const MortarStep& step, PairMemory& memory);

}  // namespace cbr
