// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>

namespace cbr::hdf5 {

// False when a heap of variable-length strings ("global heap collection" of the HDF5 file format
// specification, III.E) is damaged. It is the one structure of our files without a checksum, and
// the library (1.10.8) copies from wherever it points to. Looked at: the whole file up to 64 MB; of
// a larger one the first and the last 16 MB, where our writer puts its strings. And false when
// `visit`, which goes through the file as the library sees it, does not survive that in a process
// of its own: some structures of other programs' files have no checksums either. Both are asked
// once for a file, and `visit` again if it is now to see the `whole` of it.
bool is_sound(const std::filesystem::path& file, bool whole, const std::function<void()>& visit);

}  // namespace cbr::hdf5
