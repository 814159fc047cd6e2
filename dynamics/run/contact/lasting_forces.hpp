// SPDX-License-Identifier: GPL-3.0-or-later
// Forces of contact that persist over steps: docs/theory.md, "Forces that last".
#pragma once

#include "dynamics/run/contact/contact_group.hpp"

namespace cbr {

// Fills lasting_next of the group's bodies. For `impulse` contact, after the impulses of a step h
// are known and remembered by its pairs.
void find_lasting_forces(Simulation& simulation, const ContactGroup& group,
                         const EnforcementResult& result, double h, ContactState& state);

// Passes lasting_next to the bodies, which move under it in the next step. Call after all groups of
// the step.
void hand_lasting_forces(Simulation& simulation, double h, ContactState& state,
                         ContactOutcome& outcome);

}  // namespace cbr
