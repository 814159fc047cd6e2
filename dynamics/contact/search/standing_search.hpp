// SPDX-License-Identifier: GPL-3.0-or-later
// A pair that does not slide is not searched: feet, weights and normals of its last search stand.
#pragma once

#include "dynamics/contact/search/detection.hpp"

namespace cbr {

// Appends the points of the last search with the gaps of this step, and returns true: while no
// point has slipped by more than a share of a face since, and no node that had no point can have
// come near. Positions are those of detect().
bool take_standing(const ContactSurface& slave, const ContactBody& slave_body,
                   const ContactSurface& master, const ContactBody& master_body,
                   const DetectionOptions& options, const PairMemory& memory, ContactList& list);

// Keeps the points from `first` on, which detect() or detect_both() has just found, for the steps
// to come; those of the other side's nodes begin at `nodes`, those of edges at `both`.
void keep_standing(const ContactSurface& slave, const ContactBody& slave_body,
                   const ContactSurface& master, const ContactBody& master_body,
                   const ContactList& list, std::size_t first, std::size_t nodes, std::size_t both,
                   PairMemory& memory);

}  // namespace cbr
