// SPDX-License-Identifier: GPL-3.0-or-later
// Newmark: the velocities of closed contact at the end of a step.
#pragma once

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/run/contact/contact_group.hpp"
#include "dynamics/run/contact/contact_step.hpp"

namespace cbr {

// Whether the group's bodies are stepped by Newmark, whose velocities are to be settled.
bool is_newmark(const Simulation& simulation, const ContactGroup& group);

// Impulses at the end of the step that stop what is closed from moving into or, tied, along its
// partner. `result` has the step's impulses, and gets these on top. memory: of the step's impulses,
// or null.
void settle(Simulation& simulation, const ContactGroup& group, const ImpulseMemory* memory,
            ContactState& state, EnforcementResult& result);

}  // namespace cbr
