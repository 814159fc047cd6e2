// SPDX-License-Identifier: GPL-3.0-or-later
// What must be known of a .msh file before libgmsh reads it: libgmsh takes some damaged files without a word, runs files of
// other kinds as its own scripts, and forgets which physical group an element of format 2 was in.
#pragma once

#include <filesystem>
#include <unordered_map>

#include "common/types.hpp"

namespace cbr {

struct MshFile {
  double version = 0;
  bool binary = false;
  Index n_nodes = 0, n_elements = 0;          // as the file announces them
  std::unordered_map<Index, Index> physical;  // format 2: element number -> physical group, 0: none
};

// InputError: not a .msh file, a format other than 2.x and 4.1, sections that are missing or cut short, impossible counts.
MshFile inspect_msh(const std::filesystem::path& file);

}  // namespace cbr
