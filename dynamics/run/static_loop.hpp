// SPDX-License-Identifier: GPL-3.0-or-later
// A run of statics: equilibrium at the end of each load step.
#pragma once

#include "dynamics/run/run.hpp"

namespace cbr {

// As run(), for a simulation that is_static.
RunResult run_static(Simulation& simulation, const RunOptions& options);

}  // namespace cbr
