// SPDX-License-Identifier: GPL-3.0-or-later
// Checks the output files of a run before its first step. No output replaces another output, an
// input, or a foreign file.
#pragma once

#include <filesystem>
#include <string>

#include "common/scene/scene.hpp"

namespace cbr {

// The files of one run; an empty path: not written, or not given.
struct RunFiles {
  std::filesystem::path results, restart, timings;
  std::string format = "cbr-results";  // of `results`, which replaces files of this format only
  std::filesystem::path table = {};    // CSV
};

// Checks all outputs: results, fields, checkpoint and its fields, timings. InputError with the file
// and the option to change, if two have one name. Also if an output would replace an input (scene,
// mesh, superelement, checkpoint of a restart) or a file of another kind. RunError if one cannot be
// written.
void check_outputs(const Scene& scene, const RunFiles& files);

// Beside the results file: impact.xdmf and impact.fields.h5, or impact.exo.
std::filesystem::path exodus_file(const std::filesystem::path& results);
std::filesystem::path xdmf_file(const std::filesystem::path& results);
std::filesystem::path fields_file(const std::filesystem::path& results);

}  // namespace cbr
