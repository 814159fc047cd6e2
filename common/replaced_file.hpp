// SPDX-License-Identifier: GPL-3.0-or-later
// A mistyped name of an output must not cost the user another file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cbr {

// InputError when `target` is an HDF5 file whose root attribute 'format' is none of `formats`: "FILE: is a checkpoint of cbr-dyn
// (HDF5, format cbr-checkpoint), which WHAT would replace: CURE". What is not there, damaged, or no HDF5 file passes.
void refuse_other_hdf5(const std::filesystem::path& target, const std::vector<std::string>& formats, const std::string& what,
                       const std::string& cure);

}  // namespace cbr
