// SPDX-License-Identifier: GPL-3.0-or-later
// Contact in the summary of a run.
#pragma once

#include "common/app/report.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Warns of pairs with an initial overlap above round-off and `adjust`. Call after the first step,
// in which contact detects it.
void warn_of_initial_overlaps(const BuiltScene& built, Report& report);

// A line per pair, and warnings; with many pairs of `all` only those that met. `is_restarted`: gaps
// were watched since the restart.
void contact_lines(const BuiltScene& built, bool is_restarted, Report& report);

}  // namespace cbr
