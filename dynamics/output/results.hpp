// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/output: results, fields, energies, checkpoints.
//
// The results file (format "cbr-results", formats.md).
#pragma once

#include <filesystem>

#include "common/app/report.hpp"
#include "dynamics/run/simulation.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// InputError, before the run, when the outputs that it is to keep until it ends would take more
// than `memory` bytes: how much, and what output.every would do. Pairs that `contact: all` stands
// for count from when they meet, so not here.
void require_memory_for_outputs(const Scene& scene, const Simulation& simulation, double memory);

// Wall times are attributes, so the datasets are the same bytes from run to run. RunError when the
// disk refuses; nothing half-written.
void write_results(const std::filesystem::path& file, const Simulation& simulation,
                   const RunResult& result, const Report& report);

}  // namespace cbr
