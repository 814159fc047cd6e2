// SPDX-License-Identifier: GPL-3.0-or-later
// What a solution of contact leaves in the pairs: resultants, extremes, and what the next search knows.
#pragma once

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/run/contact_group.hpp"
#include "dynamics/run/contact_step.hpp"

namespace cbr {

// Sums of the pairs and contact bodies since the last output, and the outcome of the step.
void book(Simulation& simulation, const ContactGroup& group, const EnforcementResult& result, ContactState& state,
          ContactOutcome& outcome);

// What the pairs' next search starts from.
void remember(const Simulation& simulation, const ContactGroup& group, const EnforcementResult& result);

}  // namespace cbr
