// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/exchange/import: superelements of matrices from other codes: one file a
// format.
//
// cbr-reduce --import: a superelement file from the files of another code.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/base/types.hpp"
#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {

struct ImportOptions {
  std::string format;           // one of import_format_names()
  std::filesystem::path file;   // see import_matrices()
  std::filesystem::path faces;  // a mesh that has the interface's nodes and faces; empty: none
  std::filesystem::path target;
  // with `faces`: the diagonal form is stored for up to this many coordinates
  Index diagonal_limit = 0;
};

// Writes `target`, whole or not at all. Warns of the file's limits without `faces`. InputErrors:
// those of import_matrices(), superelement_of() and add_faces(); `target` is one of the files that
// are read, or a file of another kind. RunError: of the disk.
void import_superelement(const ImportOptions& options, Report& report);

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
