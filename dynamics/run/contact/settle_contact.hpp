// SPDX-License-Identifier: GPL-3.0-or-later
// After the impulses of a step: velocities of closed contact with Newmark, and forces that persist
// over steps (docs/theory.md, "Forces that last").
#pragma once

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/run/contact/contact_group.hpp"
#include "dynamics/run/contact/contact_step.hpp"

namespace cbr {

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

// lasting_forces.cpp
// Fills lasting_next of the group's bodies. For `impulse` contact, after the impulses of a step h
// are known and remembered by its pairs.
void find_lasting_forces(Simulation& simulation, const ContactGroup& group,
                         const EnforcementResult& result, double h, ContactState& state);

// Passes lasting_next to the bodies, which move under it in the next step. Call after all groups of
// the step.
void hand_lasting_forces(Simulation& simulation, double h, ContactState& state,
                         ContactOutcome& outcome);

}  // namespace cbr
