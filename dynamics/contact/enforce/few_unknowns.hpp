// SPDX-License-Identifier: GPL-3.0-or-later
// `impulse` with fewer unknowns than points: pressures of functions, and points of rigid bodies
// that are found one by one.
#pragma once

#include <optional>
#include <vector>

#include "dynamics/contact/enforce/enforcement.hpp"

namespace cbr {

// A body that turns has a new response in each step.
bool any_turns(const ContactList& list, const std::vector<ContactBody>& bodies);

// The laws hold for `unknowns`, which are reduced and may become more. W of few unknowns is formed
// and factored whenever they change. As enforce_impulse().
EnforcementResult enforce_in_functions(const ContactList& list, const std::vector<PointLaw>& laws,
                                       const std::vector<FunctionsOfSearch>& searches,
                                       ContactUnknowns& unknowns, double h,
                                       std::vector<ContactBody>& bodies, ImpulseMemory& memory);

// Bodies that no force deforms give way in six motions each: few points hold them, and all others
// stay apart then.
bool are_rigid(const ContactList& list, const std::vector<ContactBody>& bodies);
// As enforce_impulse(), of rigid bodies; none: too many rounds, every point is an unknown.
std::optional<EnforcementResult> enforce_point_by_point(
    const ContactList& list, const std::vector<PointLaw>& laws, const Points& guess,
    const std::vector<FunctionsOfSearch>& searches, double h, std::vector<ContactBody>& bodies,
    ImpulseMemory& memory);

}  // namespace cbr
