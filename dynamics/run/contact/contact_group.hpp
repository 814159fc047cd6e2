// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs that are solved together in a step, the points of their searches, and what is done with
// them: each in the file that is named.
#pragma once

#include <vector>

#include "dynamics/contact/enforce/enforcement.hpp"
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

// contact_booking.cpp: transfers a solution of contact to the pairs: resultants, extremes, and the
// state for the next search.

// Adds to sums of pairs and contact bodies since the last output, and to the outcome of the step.
void book(Simulation& simulation, const ContactGroup& group, const EnforcementResult& result,
          ContactState& state, ContactOutcome& outcome);

// Work of moving walls on the bodies. h: length of the step. In statics first with the forces at
// the start of a load step, for all pairs, then with those at its end.
void book_walls(Simulation& simulation, const ContactGroup& group, const EnforcementResult& result,
                double h, const ContactState& state);
void book_last_forces_of_walls(Simulation& simulation);
void book_walls_in_statics(Simulation& simulation, const ContactGroup& group,
                           const EnforcementResult& result);
// After the step's enforcement: work of friction on the bodies. is_static: of a load step, h = 1.
void book_friction(const Simulation& simulation, double h, bool is_static, ContactState& state);
// Lasting forces add a part of their impulse to a body's momentum before the step ends. p: forces
// at the group's points, as EnforcementResult::p; end: for walls out of reach in the step.
void book_lasting_forces_of_walls(Simulation& simulation, const ContactGroup& group,
                                  const Points& p, double h);
void end_lasting_forces_of_walls(Simulation& simulation, const ContactOutcome& outcome, double h);

// State for the next search of the pairs, and the slip speed that friction depends on. h: length of
// the step; 0: statics, without slip.
void remember(Simulation& simulation, const ContactGroup& group, const EnforcementResult& result,
              double h, const ContactState& state);

// settle_contact.cpp: after the impulses of a step, velocities of closed contact with Newmark.

// Whether the group's bodies use Newmark, whose velocities need a correction.
bool is_newmark(const Simulation& simulation, const ContactGroup& group);

// `impulse`, and by pairs with a restitution, between rigid bodies and walls: points that land
// leave with that share of their normal velocity (docs/theory.md, "Restitution"). Reduces the share
// where friction would add energy.
EnforcementResult enforce_and_rebound(Simulation& simulation, ContactGroup& group, double h,
                                      ContactState& state, ImpulseMemory& memory);

// Impulses at the end of the step that stop closed points from moving into or, if tied, along the
// partner. Adds them to `result`, which has the step's impulses. memory: of the step's impulses, or
// null.
void settle(Simulation& simulation, const ContactGroup& group, const ImpulseMemory* memory,
            ContactState& state, EnforcementResult& result);

// lasting_forces.cpp: forces that persist over steps (docs/theory.md, "Forces that last").

// Fills lasting_next of the group's bodies. For `impulse` contact, after the impulses of a step h
// are known and remembered by its pairs.
void find_lasting_forces(Simulation& simulation, const ContactGroup& group,
                         const EnforcementResult& result, double h, ContactState& state);

// Passes lasting_next to the bodies, which move under it in the next step. Call after all groups of
// the step.
void hand_lasting_forces(Simulation& simulation, double h, ContactState& state,
                         ContactOutcome& outcome);

// turning_links.cpp: links and ties of bodies with large rotation, and links whose springs bend.

// Directions of a link's rows in this step, 3 x 3 (theory.md, "Links of bodies that turn"). Call
// when the start of the step is known and before responses are requested. Updates its spring, and
// the sliding point of the first end.
Matrix3 aim_link(Simulation& simulation, const ContactPair& pair, ContactState& state);

// Frame of a tie in this step. Where it constrains some directions, it rotates with the master.
Matrix3 tie_frame(const Simulation& simulation, const ContactPair& pair, const ContactPoint& point);

// Separation, at the predicted end of the step, of point i of a tied pair or a link; in the frame
// of the point.
Vector3 separation(const Simulation& simulation, const ContactPair& pair, std::size_t i,
                   const ContactState& state);

// Impulses act at the start positions of nodes, but contact is at their end. The two sides of a
// point differ by some of the step's slip. Each side gets half of the resulting moment, so that all
// moments sum to 0. p: of the group's points. Fills the moments of the bodies.
void balance_moments(const Simulation& simulation, const ContactGroup& group, const Points& p,
                     ContactState& state);

// Whether linear responses do not close the group's ties and links: those of bodies with large
// rotation, and springs that bend (BodyFacts).
bool does_not_close(const Simulation& simulation, const ContactGroup& group);

// Before responses are requested: drops those of springs that have a new one. Returns whether any
// has.
bool renew_springs(const Simulation& simulation, const ContactGroup& group, ContactState& state);

// Closes links and ties at the bodies' new positions after the group's impulses are applied. Adds
// the impulses to the bodies and to `result`. RunError: no convergence.
void close_links(Simulation& simulation, const ContactGroup& group, double h, ContactState& state,
                 EnforcementResult& result);

}  // namespace cbr
