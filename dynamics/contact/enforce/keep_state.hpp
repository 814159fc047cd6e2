// SPDX-License-Identifier: GPL-3.0-or-later
// What contact keeps from step to step, for checkpoints (common/files/state_archive.hpp). Workspace
// that each step fills anew is left out.
#pragma once

#include "common/files/state_archive.hpp"
#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/laws/keep_state.hpp"

namespace cbr {

void keep_state(StateArchive& archive, PointKey& key);
void keep_state(StateArchive& archive, PenaltyMemory& memory);
// W and what is factored of it as they are: both have come about step by step, and made anew they
// would differ in last digits.
void keep_state(StateArchive& archive, ImpulseMemory& memory);
// Without the responses, which are the bodies' to give.
void keep_state(StateArchive& archive, ContactBody& body);

}  // namespace cbr
