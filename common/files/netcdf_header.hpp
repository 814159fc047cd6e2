// SPDX-License-Identifier: GPL-3.0-or-later
// For netcdf_file.cpp.
#pragma once

#include <filesystem>

namespace cbr {

// Checks the header of a classic netCDF file (CDF-1, 2, 5). InputError where it is damaged, or
// where a variable ends beyond the file. The library crashes on some damaged headers, and reads
// zeros beyond the end of a file. Other files pass: false. Grammar: NetCDF Classic and 64-bit
// Offset File Formats, OGC 11-054r1, and its 64-bit data extension.
bool check_classic_netcdf(const std::filesystem::path& file);

}  // namespace cbr
