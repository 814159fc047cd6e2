// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-reduce --import: reduced matrices from the files of another code.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {

std::vector<std::string> import_format_names();

struct ImportedMatrices {
  ReducedMatrices reduced;                   // rows in the files' order
  std::vector<std::filesystem::path> files;  // all that were read
  std::string users;                         // for messages: the codes that write them
  bool needs_mesh = false;                   // rows have no positions: see place_rows()
};

// `file`: the superelement of Sierra/SD, the file of a substructure; of other formats one of the
// files of one name, or their names' common beginning. InputError: another format; a file that is
// missing, damaged or of another kind, with its line.
ImportedMatrices import_matrices(const std::string& format, const std::filesystem::path& file);

}  // namespace cbr
