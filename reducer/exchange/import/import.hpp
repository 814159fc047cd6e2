// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/exchange/import: superelements of matrices from other codes: one file a
// format.
//
// cbr-reduce --import: a superelement file from the files of another code.
#pragma once

#include <filesystem>
#include <string>

#include "common/app/report.hpp"
#include "common/base/types.hpp"

namespace cbr {

struct ImportOptions {
  std::string format;           // one of import_format_names()
  std::filesystem::path file;   // see import_matrices()
  std::filesystem::path faces;  // a mesh that has the interface's nodes and faces; empty: none
  std::filesystem::path target;
  // with `faces`: the diagonal form is stored for up to this many coordinates
  Index diagonal_limit = 0;
};

// Writes `target`, whole or not at all. Without `faces` a warning says what the file cannot do.
// InputErrors: those of import_matrices(), superelement_of() and add_faces(); `target` is one of
// the files that are read, or a file of another kind. RunError: of the disk.
void import_superelement(const ImportOptions& options, Report& report);

}  // namespace cbr
