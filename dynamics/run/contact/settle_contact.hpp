// SPDX-License-Identifier: GPL-3.0-or-later
// Newmark: the velocities of closed contact at the end of a step.
#pragma once

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/run/contact/contact_group.hpp"
#include "dynamics/run/contact/contact_step.hpp"

namespace cbr {

// Whether the group's bodies use Newmark, whose velocities need a correction.
bool is_newmark(const Simulation& simulation, const ContactGroup& group);

// Impulses at the end of the step that stop closed points from moving into or, if tied, along the
// partner. Adds them to `result`, which has the step's impulses. memory: of the step's impulses, or
// null.
void settle(Simulation& simulation, const ContactGroup& group, const ImpulseMemory* memory,
            ContactState& state, EnforcementResult& result);

}  // namespace cbr
