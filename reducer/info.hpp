// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-reduce --info FILE: what a file of ours is, in words.
#pragma once

#include <filesystem>
#include <iosfwd>

namespace cbr {

// Superelements and groups of them: provenance, dofs, lowest frequencies, faces, mass, errors.
// Results, fields and checkpoints: times, steps, instances. InputError: missing, damaged, or a file
// of another kind.
void print_info(const std::filesystem::path& file, std::ostream& out);

}  // namespace cbr
