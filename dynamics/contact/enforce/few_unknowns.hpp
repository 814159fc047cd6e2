// SPDX-License-Identifier: GPL-3.0-or-later
// `impulse` with fewer unknowns than points: pressure functions, or active points of rigid bodies.
#pragma once

#include <optional>
#include <vector>

#include "dynamics/contact/enforce/enforcement.hpp"

namespace cbr {

// Whether a body has large rotation, and so a new response in each step.
bool any_turns(const ContactList& list, const std::vector<ContactBody>& bodies);

// As enforce_impulse() for reduced `unknowns`, to which points may be added. W is small: it is
// formed and factored whenever the unknowns change.
EnforcementResult enforce_in_functions(const ContactList& list, const std::vector<PointLaw>& laws,
                                       const std::vector<FunctionsOfSearch>& searches,
                                       ContactUnknowns& unknowns, double h,
                                       std::vector<ContactBody>& bodies, ImpulseMemory& memory);

// Whether all bodies are rigid. With six motions each a few points constrain them, and all others
// stay apart.
bool are_rigid(const ContactList& list, const std::vector<ContactBody>& bodies);
// As enforce_impulse(), for rigid bodies. None: too many rounds, use every point as an unknown.
std::optional<EnforcementResult> enforce_point_by_point(
    const ContactList& list, const std::vector<PointLaw>& laws, const Points& guess,
    const std::vector<FunctionsOfSearch>& searches, double h, std::vector<ContactBody>& bodies,
    ImpulseMemory& memory);

}  // namespace cbr
