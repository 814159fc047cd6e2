// SPDX-License-Identifier: GPL-3.0-or-later
// Files of results without time steps: harmonic response, and modes with their shapes.
#pragma once

#include <filesystem>

#include "common/app/report.hpp"
#include "dynamics/setup/modal/harmonic.hpp"
#include "dynamics/setup/modal/scene_modes.hpp"

namespace cbr {

// File of the table beside the results: sweep.csv.
std::filesystem::path sweep_table(const std::filesystem::path& results);

// Writes HDF5, and the table beside it. RunError for disk errors.
void write_sweep(const std::filesystem::path& file, const HarmonicResponse& response);

// Writes frequencies and damping ratios to HDF5, and shapes as fields beside it. The time of a
// shape is the mode's number, from 1.
void write_modes(const std::filesystem::path& file, SceneModes& modes, Report& report);

}  // namespace cbr
