// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that are tied for the whole run.
#pragma once

#include <optional>
#include <string>

#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// Without `adjust`, surfaces count as joined within this share of the face's size.
constexpr double usual_adjust = 0.05;

struct TieReport {
  // slave nodes without a tie: no master face within the tolerance
  Index without_partner = 0;
  double largest_offset = 0;  // of tied nodes: distance from the face
  // Relative rigid motions that the tie leaves free: 3 for one point, 1 for points on a line.
  Index free_motions = 0;
  Index n_points = 0;  // that were found
};

// "2 of its 4 nodes are tied", and free motions: "... along one line only: ..."; empty if it
// constrains all of the slave's nodes.
std::string tie_text(const TieReport& report, const ContactSurface& slave);

// Ties each slave node to the closest point of the master's faces at these positions (rows: contact
// nodes of each body). `tolerance`: largest distance (length; default: 5 % of the face's size).
// Appends points of identity frame and constant weights to `ties`. Appends the relative positions
// that they keep, sum coefficient x position, to `offsets` (points x 3, scene axes). The master's
// part of the offset does not rotate with the body. So a couple of offset x force is lost, as small
// as the offset.
TieReport tie_surfaces(const ContactSurface& slave, const Points& slave_positions,
                       const ContactSurface& master, const Points& master_positions,
                       std::optional<double> tolerance, ContactList& ties, Points& offsets);

// The same with the points of detect_mortar(): for slave nodes whose mean distance from the master
// is within `tolerance`.
TieReport tie_mortar(const ContactSurface& slave, const Points& slave_positions,
                     const ContactSurface& master, const Points& master_positions,
                     const DetectionOptions& options, std::optional<double> tolerance,
                     ContactList& ties, Points& offsets);

// For two rigid bodies: three points that are far apart, with the six rows that are independent; on
// a line two points, with five. More rows contradict each other at second order in a rotation.
// `positions`: the slave's; the frames are for these. The first point takes the area of all.
void keep_independent(Index slave, const Points& positions, ContactList& ties, Points& offsets);

}  // namespace cbr
