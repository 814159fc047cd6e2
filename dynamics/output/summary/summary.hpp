// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/output/summary: what a run tells on the terminal, before, during and after
// its steps.
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
  double energy_off = 0;        // the same, not divided
  double momentum_off = 0;      // |p(t) - p(0)|
  double momentum = 0;          // the same / sum over bodies of the largest |p|
  double angular_momentum = 0;  // likewise, but at least momentum x distance as the scale
};
Balance balance(const RunResult& result);

// Before the first step: instances, dofs, steps and what limits them. is_again: the instances have
// been told.
void announce(const BuiltScene& built, bool is_again, Report& report);

// Balances and contact, each figure with what is good, and warnings for what looks wrong. Counters
// with --verbose alone.
void summarise(const BuiltScene& built, const RunResult& result, bool is_restarted, Report& report);

}  // namespace cbr
