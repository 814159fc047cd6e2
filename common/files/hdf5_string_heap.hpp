// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>

namespace cbr::hdf5 {

// False when a heap of variable-length strings ("global heap collection" of the HDF5 file format
// specification, III.E) is damaged. It is the one structure of our files without a checksum, and
// the library (1.10.8) follows its pointers unchecked. Checks the whole file up to 64 MB. Of a
// larger one the first and the last 16 MB, where our writer puts its strings. Also false when
// `visit`, which reads the file by the library, crashes in a process of its own. Some structures of
// other programs' files have no checksums either. Both run once for a file, and `visit` again for
// the first `whole` reading.
bool is_sound(const std::filesystem::path& file, bool whole, const std::function<void()>& visit);

}  // namespace cbr::hdf5
