// SPDX-License-Identifier: GPL-3.0-or-later
// What the summary says of contact.
#pragma once

#include "common/app/report.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Pairs that overlap at the start, by more than round-off and `adjust`. After the first step:
// contact has looked at them then.
void warn_of_initial_overlaps(const BuiltScene& built, Report& report);

// A line for each pair, and warnings; of many pairs of `all` only those that met. `is_restarted`:
// gaps were watched from there.
void contact_lines(const BuiltScene& built, bool is_restarted, Report& report);

}  // namespace cbr
