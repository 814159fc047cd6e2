// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/output: results, fields, energies, checkpoints.
//
// The results file (format "cbr-results", formats.md).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// InputError, before the run, when two sets or pairs would have one group in the results.
void refuse_names_that_meet(const Simulation& simulation);
// InputError, before the run, when the outputs that it is to keep until it ends would take more
// than `memory` bytes: how much, and what output.every would do. Pairs that `contact: all` stands
// for count from when they meet, so not here.
void require_memory_for_outputs(const Scene& scene, const Simulation& simulation, double memory);

// Of an instance that is a superelement: its file, as seen from the folder of the results, and the
// content_hash that it has at the start.
struct SuperelementOfInstance {
  std::string instance, file, content_hash;
};
std::vector<SuperelementOfInstance> superelements_of(const Scene& scene,
                                                     const std::filesystem::path& results);

// outside_basis: the share of the energy that impulses have taken outside the basis, if known. Wall
// times and the report's warnings are attributes, so the datasets are the same bytes from run
// to run. RunError when the disk refuses; nothing half-written.
void write_results(const std::filesystem::path& file, const Simulation& simulation,
                   const RunResult& result, const Report& report,
                   const std::vector<SuperelementOfInstance>& superelements = {},
                   std::optional<double> outside_basis = {});

}  // namespace cbr
