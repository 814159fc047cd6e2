// SPDX-License-Identifier: GPL-3.0-or-later
// XDMF text beside a file of fields, the index for viewers.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "dynamics/output/field_grids.hpp"

namespace cbr {

// Groups of the file of fields, with a trailing slash.
std::string step_group(std::size_t step);
std::string grid_group(std::size_t grid);

// Writes XDMF 3: at each time all grids with their fields, stress as one scalar per dataset of
// datasets_of(). `heavy`: the file of fields, as named in the text.
void write_xdmf(std::ostream& out, const std::filesystem::path& heavy,
                const std::vector<double>& times, const std::vector<FieldGrid>& grids,
                const std::vector<std::string>& fields);

}  // namespace cbr
