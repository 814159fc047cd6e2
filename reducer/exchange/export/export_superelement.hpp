// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-reduce --export: a superelement for another code.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/app/report.hpp"

namespace cbr {

std::vector<std::string> export_format_names();

// Exports the superelement `file` as FORMAT: `target` with the format's suffixes, and
// `target`.dofs.csv, the table of rows. All files are whole or none is there. `first_modal_node` as
// of reduced_matrices(). InputError: another format; a file that is no superelement, or whose basis
// or domains have no such matrices; one of the files to write is `file` itself. RunError: of the
// disk.
void export_superelement(const std::string& format, const std::filesystem::path& file,
                         const std::filesystem::path& target, Index first_modal_node,
                         Report& report);

}  // namespace cbr
