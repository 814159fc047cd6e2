// SPDX-License-Identifier: GPL-3.0-or-later
// What cbr-skin does, apart from its command line.
#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "common/app/report.hpp"

namespace cbr {

struct SkinCommand {
  // a scene, "-" for a scene on stdin, or a mesh (by its suffix)
  std::string input;
  std::vector<std::string> sidesets;  // of a mesh
  std::filesystem::path output;       // needed for a mesh; in place of the scene's skin: mesh
};

// Writes the skinned mesh, and for a scene the scene, with the mesh filled in, to `scene_out`
// unless that is null. Warns of superelements that are there and not of the present inputs.
// InputError: those of the readers; options that do not belong together. RunError: a mesh was
// replaced meanwhile.
void run_skin(const SkinCommand& command, std::ostream* scene_out, Report& report);

}  // namespace cbr
