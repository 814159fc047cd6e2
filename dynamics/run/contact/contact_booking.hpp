// SPDX-License-Identifier: GPL-3.0-or-later
// Transfers a solution of contact to the pairs: resultants, extremes, and the state for the next
// search.
#pragma once

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/run/contact/contact_group.hpp"
#include "dynamics/run/contact/contact_step.hpp"

namespace cbr {

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

}  // namespace cbr
