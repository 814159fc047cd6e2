// SPDX-License-Identifier: GPL-3.0-or-later
// What a solution of contact leaves in the pairs: resultants, extremes, and what the next search
// knows.
#pragma once

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/run/contact/contact_group.hpp"
#include "dynamics/run/contact/contact_step.hpp"

namespace cbr {

// Sums of the pairs and contact bodies since the last output, and the outcome of the step.
void book(Simulation& simulation, const ContactGroup& group, const EnforcementResult& result,
          ContactState& state, ContactOutcome& outcome);

// What walls that move have done on the bodies: h, a step's length; in statics first of the forces
// at the start of a load step, for all pairs, and then of those at its end.
void book_walls(Simulation& simulation, const ContactGroup& group, const EnforcementResult& result,
                double h);
void book_last_forces_of_walls(Simulation& simulation);
void book_walls_in_statics(Simulation& simulation, const ContactGroup& group,
                           const EnforcementResult& result);
// Of forces that last a body's momentum has a share before it is given. p: those on the group's
// points, as EnforcementResult::p; end: of walls that nothing has been near to in the step.
void book_lasting_forces_of_walls(Simulation& simulation, const ContactGroup& group,
                                  const Points& p, double h);
void end_lasting_forces_of_walls(Simulation& simulation, const ContactOutcome& outcome, double h);

// What the pairs' next search starts from.
void remember(const Simulation& simulation, const ContactGroup& group,
              const EnforcementResult& result);

}  // namespace cbr
