// SPDX-License-Identifier: GPL-3.0-or-later
// What points, pairs and W keep from step to step, for checkpoints
// (common/files/state_archive.hpp).
#pragma once

#include "common/files/state_archive.hpp"
#include "dynamics/contact/response/response.hpp"
#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/motion_bound.hpp"
#include "dynamics/contact/surfaces/pair_memory.hpp"

namespace cbr {

void keep_state(StateArchive& archive, Box& box);
void keep_state(StateArchive& archive, MotionBound& bound);
void keep_state(StateArchive& archive, ContactTerm& term);
void keep_state(StateArchive& archive, ContactPoint& point);
void keep_state(StateArchive& archive, ContactList& list);
void keep_state(StateArchive& archive, PointLaw& law);
void keep_state(StateArchive& archive, GapResponse& W);
void keep_state(StateArchive& archive, PairMemory& memory);

}  // namespace cbr
