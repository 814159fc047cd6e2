// SPDX-License-Identifier: GPL-3.0-or-later
// Which pairs are solved together in a step, and the points that their searches find.
#pragma once

#include <vector>

#include "dynamics/run/contact/contact_step.hpp"

namespace cbr {

// The points that one search of a pair has found: its slave's nodes, or those of its master in a
// two-way contact.
struct ContactSearch {
  Index pair = 0;
  PairMemory* memory = nullptr;
  std::size_t first = 0, last = 0;
};

// The points of some pairs, solved together.
struct ContactGroup {
  std::vector<ContactSearch> searches;
  ContactList list;
  std::vector<PointLaw> laws;
  Points guess;               // impulses of the last step, in the points' frames
  std::vector<Index> bodies;  // contact bodies that a point has terms on, ascending
};

// The points of `pairs` at the bodies' start and predicted end; slips of those with friction are
// filled. extra_reach: a length by which searches reach farther than this motion asks for.
ContactGroup collect(Simulation& simulation, const std::vector<Index>& pairs, bool initial,
                     ContactState& state, double extra_reach = 0);

// The functions that the searches of a group may have as unknowns.
std::vector<FunctionsOfSearch> functions_of(const Simulation& simulation,
                                            const ContactGroup& group);

// Of the due pairs those of one enforcement, pairs that share a body together.
std::vector<std::vector<Index>> islands(const Simulation& simulation, const std::vector<Index>& due,
                                        Enforcement enforcement);

}  // namespace cbr
