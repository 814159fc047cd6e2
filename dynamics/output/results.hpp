// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/output: results, fields, energies, checkpoints, summary.
//
// The results file (format "cbr-results", formats.md) and the summary of a run.
#pragma once

#include <filesystem>

#include "common/app/report.hpp"
#include "dynamics/run/simulation.hpp"
#include "dynamics/setup/build.hpp"

namespace cbr {

// InputError, before the run, when the outputs that it is to keep until it ends would take more than `memory` bytes: how much, and
// what output.every would do. Pairs that `contact: all` stands for count from when they meet, so not here.
void require_memory_for_outputs(const Scene& scene, const Simulation& simulation, double memory);

// Wall times are attributes, so the datasets are the same bytes from run to run. RunError when the disk refuses; nothing
// half-written.
void write_results(const std::filesystem::path& file, const Simulation& simulation, const RunResult& result, const Report& report);

// Largest errors of the run's balances.
struct Balance {
  double energy = 0;            // |E(t) - E(0) - work of loads, contact and friction| / largest energy or work
  double momentum = 0;          // |p(t) - p(0)| / sum over bodies of the largest |p|
  double angular_momentum = 0;  // likewise, but at least momentum x distance as the scale
};
Balance balance(const RunResult& result);

// Before the first step: instances, dofs, steps and what limits them.
void announce(const BuiltScene& built, Report& report);

// Balances and contact, each figure with what is good, and warnings for what looks wrong. Counters with --verbose alone.
void summarise(const BuiltScene& built, const RunResult& result, bool is_restarted, Report& report);

}  // namespace cbr
