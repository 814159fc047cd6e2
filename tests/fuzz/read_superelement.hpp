// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace cbr::fuzz {

// Reads a superelement or a group, writes it and reads it again. False: rejected.
bool read_any_superelement(const std::filesystem::path& file);

}  // namespace cbr::fuzz
