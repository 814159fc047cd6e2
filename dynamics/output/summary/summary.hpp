// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/output/summary: terminal output of a run, before, during and after its
// steps.
#pragma once

#include "common/app/report.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Largest errors of the run's balances.
struct Balance {
  // |E(t) - E(0) - work of loads, contact and friction| / largest energy or work
  double energy = 0;
  double energy_off = 0;        // the same, not relative
  double momentum_off = 0;      // |p(t) - p(0)|
  double momentum = 0;          // momentum_off / sum over bodies of the largest |p|
  double angular_momentum = 0;  // likewise, with a scale of at least momentum x distance
};
Balance balance(const RunResult& result);

// "3 of 100 steps"; in statics of load steps, counted from the first before time 0.
std::string steps_done(const Simulation& simulation, Index reached);

// Before the first step: instances, dofs, steps and their limits. is_again: instances have been
// reported.
void announce(const BuiltScene& built, bool is_again, Report& report);

// Reports balances and contact, each figure with its good range, and warnings. Counters with
// --verbose only.
void summarise(const BuiltScene& built, const RunResult& result, bool is_restarted, Report& report);

}  // namespace cbr
