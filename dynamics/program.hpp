// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics: cbr-dyn: one run from scene to files.
//
// Functions of cbr-dyn after its command line is read.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "common/app/report.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// Reads the scene ("-": stdin), runs it, writes `results` and the requested fields beside it.
// `restart`: a checkpoint to restart from, or empty. `timings`: file of report.write_timings(),
// which must not be another output, or empty. InputError, RunError: also after SIGINT, SIGTERM or
// SIGHUP, with the results so far written.
void run_scene(const std::string& scene_or_dash, const std::filesystem::path& results,
               Report& report, const BuildOptions& options = {},
               const std::filesystem::path& restart = {},
               const std::filesystem::path& timings = {});

// The lowest `n` frequencies of each instance of the scene, or group of tied instances, as CSV:
// instance,mode,frequency_hz,damping_ratio. `results`: if not empty, they are also written there,
// with the shapes as fields.
void print_modes(const std::string& scene_or_dash, Index n, const std::filesystem::path& results,
                 Report& report, std::ostream& out);

// Writes the harmonic response of the scene (key `sweep`) to `results` and a CSV beside it.
// InputError as of harmonic_response().
void sweep_scene(const std::string& scene_or_dash, const std::filesystem::path& results,
                 Report& report);

// InputError: --modes (above 0) or --sweep with options of a run, or no output.
void require_output(Index modes, bool sweep, const std::string& output, const std::string& restart);

}  // namespace cbr
