// SPDX-License-Identifier: GPL-3.0-or-later
// Links of bodies that turn by any angle, and what else holds such bodies together.
#pragma once

#include "dynamics/run/contact/contact_group.hpp"

namespace cbr {

// Once the start of a step is known and before responses are asked for: the directions in which
// the rows of a link act in this step, 3 x 3 (theory.md, "Links of bodies that turn"). Tells its
// spring, and the place of the first end that slides, where they are.
Matrix3 aim_link(Simulation& simulation, const ContactPair& pair, ContactState& state);

// What separates at the end of the step, so far as it is known, of point i of a tied pair or a
// link; in the frame of the point.
Vector3 separation(const Simulation& simulation, const ContactPair& pair, std::size_t i,
                   const ContactState& state);

// Impulses act where the nodes are at the start of a step, which is not where its contact is: a
// point's two sides are some of the step's slip apart. Each side of a point gets half of the moment
// that this leaves, so that the sum of all moments is 0. p: of the group's points. Fills the
// moments of the bodies.
void balance_moments(const Simulation& simulation, const ContactGroup& group, const Points& p,
                     ContactState& state);

// Whether what is held together in the group turns, so that linear answers do not close it.
bool holds_what_turns(const Simulation& simulation, const ContactGroup& group);

// After the impulses of the group have been handed out: adds what closes its links and ties where
// bodies come to by these, to the bodies and to `result`. RunError: it cannot be closed.
void close_what_turns(Simulation& simulation, const ContactGroup& group, double h,
                      ContactState& state, EnforcementResult& result);

}  // namespace cbr
