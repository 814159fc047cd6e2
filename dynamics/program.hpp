// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics: cbr-dyn: one run from scene to files.
//
// What cbr-dyn does once its command line is read.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "common/app/report.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// Reads the scene ("-": stdin), runs it, writes `results` and the fields that it asks for beside
// it. `restart`: a checkpoint to go on from, empty for none. `timings`: where
// report.write_timings() will go, which must not be another output, or empty. InputError, RunError:
// also after SIGINT, SIGTERM or SIGHUP, when what was computed so far is written.
void run_scene(const std::string& scene_or_dash, const std::filesystem::path& results,
               Report& report, const BuildOptions& options = {},
               const std::filesystem::path& restart = {},
               const std::filesystem::path& timings = {});

// Frequencies of each instance of the scene, or of those that ties join, the lowest `n`, as CSV:
// instance,mode,frequency_hz,damping_ratio. `results`: not empty to write them and the shapes as
// fields.
void print_modes(const std::string& scene_or_dash, Index n, const std::filesystem::path& results,
                 Report& report, std::ostream& out);

// Harmonic response of the scene (its key `sweep`) into `results` and a CSV beside it. InputError
// as of harmonic_response().
void sweep_scene(const std::string& scene_or_dash, const std::filesystem::path& results,
                 Report& report);

// InputError: --modes (above 0) or --sweep with what only a run has, or nothing to do.
void require_output(Index modes, bool sweep, const std::string& output, const std::string& restart);

}  // namespace cbr
