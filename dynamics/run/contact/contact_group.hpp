// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs that are solved together in a step, and the points of their searches.
#pragma once

#include <vector>

#include "dynamics/run/contact/contact_step.hpp"

namespace cbr {

// Points of one search of a pair: its slave's nodes, or the master's in two-way contact.
struct ContactSearch {
  Index pair = 0;
  PairMemory* memory = nullptr;
  std::size_t first = 0, last = 0;
};

// The points of several pairs, solved together.
struct ContactGroup {
  std::vector<ContactSearch> searches;
  ContactList list;
  std::vector<PointLaw> laws;
  Points guess;               // impulses of the last step, in the points' frames
  std::vector<Index> bodies;  // contact bodies with terms in a point, ascending
};

// Points of `pairs` at the bodies' start and predicted end, with slips for friction. extra_reach:
// reach beyond that for this motion. reuses: the last search of pairs without wall, of any body.
ContactGroup collect(Simulation& simulation, const std::vector<Index>& pairs, bool initial,
                     ContactState& state, double extra_reach = 0, bool reuses = false);

// A point's relative displacement over the step, scene axes; against a wall, relative to its
// motion.
Vector3 motion_of(const ContactPair& pair, const ContactList& list, const ContactPoint& point,
                  const ContactState& state);

// Of the body of a contact body.
const BodyFacts& facts_of(const Simulation& simulation, Index contact);

// Pressure functions that may be unknowns of a group's searches.
std::vector<FunctionsOfSearch> functions_of(const Simulation& simulation,
                                            const ContactGroup& group);

// Groups the due pairs of one enforcement; pairs that share a body are in the same group.
std::vector<std::vector<Index>> islands(const Simulation& simulation, const std::vector<Index>& due,
                                        Enforcement enforcement);

}  // namespace cbr
