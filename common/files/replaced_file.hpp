// SPDX-License-Identifier: GPL-3.0-or-later
// A mistyped name of an output must not cost the user another file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cbr {

// InputError when `target` exists and is not an HDF5 file with one of `formats` as its root
// attribute 'format': "FILE: is there and is another kind of HDF5 file (format cbr-checkpoint),
// which WHAT would replace: CURE". Empty and damaged HDF5 files pass.
void refuse_other_file(const std::filesystem::path& target, const std::vector<std::string>& formats,
                       const std::string& what, const std::string& cure);

}  // namespace cbr
