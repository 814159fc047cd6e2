// SPDX-License-Identifier: GPL-3.0-or-later
// What a run is to write, looked at before its first step: no output takes another's place, an
// input's, or that of a foreign file.
#pragma once

#include <filesystem>
#include <string>

#include "common/scene/scene.hpp"

namespace cbr {

// The files of one run; paths that are empty are not written, or not there.
struct RunFiles {
  std::filesystem::path results, restart, timings;
  std::string format = "cbr-results";  // of `results`, which replaces files of this format alone
  std::filesystem::path table = {};    // CSV
};

// InputError, naming the file and the option to change: two outputs (results, fields, checkpoint
// and its fields, timings) of one name, an output that would replace the scene, a mesh, a
// superelement, the checkpoint to go on from, or a file of another kind. RunError when one cannot
// be written.
void check_outputs(const Scene& scene, const RunFiles& files);

// Beside the results file: impact.xdmf and impact.fields.h5, or impact.exo.
std::filesystem::path exodus_file(const std::filesystem::path& results);
std::filesystem::path xdmf_file(const std::filesystem::path& results);
std::filesystem::path fields_file(const std::filesystem::path& results);

}  // namespace cbr
