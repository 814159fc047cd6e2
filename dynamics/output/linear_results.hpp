// SPDX-License-Identifier: GPL-3.0-or-later
// Files of what is computed without steps: harmonic response, and modes with their shapes.
#pragma once

#include <filesystem>

#include "common/app/report.hpp"
#include "dynamics/setup/modal/harmonic.hpp"
#include "dynamics/setup/modal/scene_modes.hpp"

namespace cbr {

// Beside the results file: sweep.csv.
std::filesystem::path sweep_table(const std::filesystem::path& results);

// HDF5, and the table beside it. RunError when the disk refuses.
void write_sweep(const std::filesystem::path& file, const HarmonicResponse& response);

// HDF5: frequencies and damping ratios; and the shapes as fields beside it, a time for each mode:
// its number, from 1.
void write_modes(const std::filesystem::path& file, SceneModes& modes, Report& report);

}  // namespace cbr
