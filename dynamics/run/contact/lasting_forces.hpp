// SPDX-License-Identifier: GPL-3.0-or-later
// Forces of contact that go on from step to step: docs/theory.md, "Forces that last".
#pragma once

#include "dynamics/run/contact/contact_group.hpp"

namespace cbr {

// Of `impulse` contact, once its impulses of a step h are known and its pairs remember them: fills
// lasting_next of the group's bodies.
void find_lasting_forces(Simulation& simulation, const ContactGroup& group,
                         const EnforcementResult& result, double h, ContactState& state);

// Once all groups of the step are through: hands lasting_next to the bodies, which move under it in
// the next step.
void hand_lasting_forces(Simulation& simulation, double h, ContactState& state,
                         ContactOutcome& outcome);

}  // namespace cbr
