// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/run: the loop over steps.
#pragma once

#include <functional>

#include "common/files/state_archive.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

struct RunOptions {
  // false: takes every step and checks every pair (for tests)
  bool jumps = true;
  std::function<void(Index step, double t)> on_output;  // with all bodies at that time
  std::function<void(double fraction)> on_progress;     // occasionally
  // statics: after each load step, including those before time 0, with iteration 0; and after each
  // iteration of the next
  std::function<void(Index done, Index all, Index iteration)> on_load_step;
  // After each step except the last: whether to end the run, with the results so far.
  std::function<bool()> is_to_end;
  // After each step except the last: whether to call `on_checkpoint` with the state for a bitwise
  // restart.
  std::function<bool(Index step, double t)> is_checkpoint;
  std::function<void(Index step, double t, const StateArchive& state)> on_checkpoint;
  // Per body, rad: larger rotations end the run, checked at outputs and after every tenth of the
  // steps. Empty: never.
  std::vector<double> turn_limit;
  StateArchive* restart = nullptr;  // state of the same simulation, built anew, to continue from

  // Asks both after a step that ends at t. keep: the state of the run.
  bool ends_here(Index step, double t, const std::function<void(StateArchive&)>& keep,
                 RunResult& result) const {
    const bool ends = is_to_end && is_to_end();
    if (is_checkpoint && is_checkpoint(step, t)) on_checkpoint(step, t, StateArchive::saved(keep));
    if (ends) result.ended_at = t;
    return ends;
  }
};

// RunError if the motion is not finite, with time and instance. InputError: `restart` is of another
// simulation. is_static: equilibrium at the end of each step. InputError: an unconstrained
// instance.
RunResult run(Simulation& simulation, const RunOptions& options = {});
// Of a simulation that is_static: called by run().
RunResult run_static(Simulation& simulation, const RunOptions& options);

}  // namespace cbr
