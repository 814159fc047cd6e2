// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace cbr::fuzz {

// Reads a superelement or a group; what is read is written and read again. False: refused.
bool read_any_superelement(const std::filesystem::path& file);

}  // namespace cbr::fuzz
