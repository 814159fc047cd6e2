// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/run: the loop over steps.
#pragma once

#include <functional>

#include "common/files/state_archive.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

struct RunOptions {
  // false: every step is taken and every pair looked at (for tests)
  bool jumps = true;
  std::function<void(Index step, double t)> on_output;  // after the bodies have arrived there
  std::function<void(double fraction)> on_progress;     // now and then
  // of statics, after each of all load steps, those before the time 0 included
  std::function<void(Index done, Index all)> on_load_step;
  // After each step but the last: whether to end the run there, with what is recorded so far.
  std::function<bool()> is_to_end;
  // After each step but the last: whether `on_checkpoint` is to get the state, from which a run
  // goes on bit for bit.
  std::function<bool(Index step, double t)> is_checkpoint;
  std::function<void(Index step, double t, const StateArchive& state)> on_checkpoint;
  // Per body, rad: the run ends once it is seen to have turned by more, at an output or after
  // every tenth of the steps. Empty: never.
  std::vector<double> turn_limit;
  StateArchive* restart = nullptr;  // to go on from, of the same simulation, built anew
};

// RunError when the motion stops being finite, by time and instance. InputError: `restart` is of
// another simulation. Of a simulation that is_static: equilibrium at the end of each step.
// InputError: an instance that nothing holds.
RunResult run(Simulation& simulation, const RunOptions& options = {});

}  // namespace cbr
