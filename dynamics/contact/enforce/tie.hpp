// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that are joined at the start, for good.
#pragma once

#include <optional>
#include <string>

#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

struct TieReport {
  // slave nodes that no tie holds, none of the master being within the tolerance
  Index without_partner = 0;
  double largest_offset = 0;  // of those that are tied: length from the face
  // Relative rigid motions that the tie leaves free: 3 of one point, 1 of points on a line.
  Index free_motions = 0;
};

// "2 of its 4 nodes are tied", and what the tie leaves free: "... along one line only: ..."; empty
// when it holds all of the slave's nodes.
std::string tie_text(const TieReport& report, const ContactSurface& slave);

// Ties each slave node to the closest point of the master's faces at these positions (rows: the
// contact nodes of either body), when it is within `tolerance` (length; not given: 5 % of the
// face's size). Appends to `ties` points of identity frame and weights that stay, and to `offsets`
// (points x 3, scene axes) the relative position sum coefficient x position that each of them
// keeps. The master's side of the offset does not turn with the body, so a couple of offset x force
// is lost: it is as small as the offset.
TieReport tie_surfaces(const ContactSurface& slave, const Points& slave_positions,
                       const ContactSurface& master, const Points& master_positions,
                       std::optional<double> tolerance, ContactList& ties, Points& offsets);

// The same with the points of detect_mortar(): slave nodes whose averaged distance from the master
// is within `tolerance`.
TieReport tie_mortar(const ContactSurface& slave, const Points& slave_positions,
                     const ContactSurface& master, const Points& master_positions,
                     const DetectionOptions& options, std::optional<double> tolerance,
                     ContactList& ties, Points& offsets);

}  // namespace cbr
