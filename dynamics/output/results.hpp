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

struct HarmonicResponse;
struct SceneModes;

// InputError before the run, if two sets or pairs would have the same group in the results.
void refuse_names_that_meet(const Simulation& simulation);
// InputError before the run, if the outputs kept until its end would need more than `memory` bytes.
// The message has their size and the effect of output.every. Pairs of `contact: all` count only
// from their first contact, so that they are not included.
void require_memory_for_outputs(const Scene& scene, const Simulation& simulation, double memory);

// For an instance that is a superelement: its file relative to the folder of the results, and its
// content_hash at the start.
struct SuperelementOfInstance {
  std::string instance, file, content_hash;
};
// Origin of the results of a run. scene: as write_scene() writes it; hash: run_hash().
struct RunInputs {
  std::string scene, hash;
  std::vector<SuperelementOfInstance> superelements;
};
RunInputs inputs_of(const Scene& scene, const std::string& hash,
                    const std::filesystem::path& results);

// outside_basis: fraction of the energy lost to truncated modes, if known. Wall times and the
// report's warnings are attributes, so that datasets are the same bytes in each run. RunError for
// disk errors; writes the whole file or nothing.
void write_results(const std::filesystem::path& file, const Simulation& simulation,
                   const RunResult& result, const Report& report, const RunInputs& inputs = {},
                   std::optional<double> outside_basis = {});

// Results without time steps: harmonic response, and modes with their shapes. The table beside the
// results: sweep.csv.
std::filesystem::path sweep_table(const std::filesystem::path& results);

// Writes HDF5, and the table beside it. RunError for disk errors.
void write_sweep(const std::filesystem::path& file, const HarmonicResponse& response);

// Writes frequencies and damping ratios to HDF5, and shapes as fields beside it. The time of a
// shape is the mode's number, from 1.
void write_modes(const std::filesystem::path& file, SceneModes& modes, Report& report);

}  // namespace cbr
