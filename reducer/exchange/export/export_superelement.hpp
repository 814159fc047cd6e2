// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-reduce --export: a superelement for another code.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/app/report.hpp"

namespace cbr {

std::vector<std::string> export_format_names();

// The superelement `file` as FORMAT: `target` with the format's suffixes, and `target`.dofs.csv,
// which tells what each row is. All files are whole or none is there. InputError: another format; a
// file that is no superelement, or of a basis or of domains that have no such matrices; one of the
// files to write is `file` itself; `first_modal_node` as of reduced_matrices(). RunError: of the
// disk.
void export_superelement(const std::string& format, const std::filesystem::path& file,
                         const std::filesystem::path& target, Index first_modal_node,
                         Report& report);

}  // namespace cbr
