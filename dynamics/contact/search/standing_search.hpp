// SPDX-License-Identifier: GPL-3.0-or-later
// Reuse of a pair's last search while it sticks: projection points, weights and normals stay.
#pragma once

#include "dynamics/contact/search/detection.hpp"

namespace cbr {

// Appends the points of the last search with the gaps of this step, and returns true. False, and
// nothing appended, if a point has slipped by more than `standing_slip` since, or a node without a
// point may have come near. Positions are those of detect().
bool take_standing(const ContactSurface& slave, const ContactBody& slave_body,
                   const ContactSurface& master, const ContactBody& master_body,
                   const DetectionOptions& options, const PairMemory& memory, ContactList& list);

// Stores the points from `first` on, which detect() or detect_both() has just found, for later
// steps. Those of the other side's nodes begin at `nodes`, those of edges at `both`.
void keep_standing(const ContactSurface& slave, const ContactBody& slave_body,
                   const ContactSurface& master, const ContactBody& master_body,
                   const ContactList& list, std::size_t first, std::size_t nodes, std::size_t both,
                   PairMemory& memory);

}  // namespace cbr
