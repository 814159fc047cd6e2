// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "tests/fuzz/byte_source.hpp"

namespace cbr::fuzz {

// Edits a whole HDF5 file by the bytes, through the library, so that its checksums stay valid:
// values, shapes, types, storage, attributes, links. Skips edits that the library rejects.
void edit_hdf5(const std::filesystem::path& file, ByteSource& bytes);

}  // namespace cbr::fuzz
