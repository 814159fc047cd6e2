// SPDX-License-Identifier: GPL-3.0-or-later
// State of contact between steps, for checkpoints (common/files/state_archive.hpp). Without the
// workspace that each step fills anew.
#pragma once

#include "common/files/state_archive.hpp"
#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/laws/keep_state.hpp"

namespace cbr {

void keep_state(StateArchive& archive, PointKey& key);
void keep_state(StateArchive& archive, PenaltyMemory& memory);
// Stores W and its factors as they are. They result from updates over steps; a new computation
// would differ in the last digits.
void keep_state(StateArchive& archive, ImpulseMemory& memory);
// Without the responses, which the bodies provide.
void keep_state(StateArchive& archive, ContactBody& body);

}  // namespace cbr
