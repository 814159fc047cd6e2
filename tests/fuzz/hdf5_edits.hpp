// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "tests/fuzz/byte_source.hpp"

namespace cbr::fuzz {

// Changes a whole HDF5 file as the bytes say, through the library, so that its checksums stay
// right: values, shapes, types, storage, attributes, links. What the library refuses to do is left
// undone.
void edit_hdf5(const std::filesystem::path& file, ByteSource& bytes);

}  // namespace cbr::fuzz
