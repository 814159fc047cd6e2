// SPDX-License-Identifier: GPL-3.0-or-later
// Links and ties of bodies with large rotation, and links whose springs bend.
#pragma once

#include "dynamics/run/contact/contact_group.hpp"

namespace cbr {

// Directions of a link's rows in this step, 3 x 3 (theory.md, "Links of bodies that turn"). Call
// when the start of the step is known and before responses are requested. Updates its spring, and
// the sliding point of the first end.
Matrix3 aim_link(Simulation& simulation, const ContactPair& pair, ContactState& state);

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
