// SPDX-License-Identifier: GPL-3.0-or-later
// The text beside a file of fields, by which viewers find them.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "dynamics/output/field_grids.hpp"

namespace cbr {

// Groups of the file of fields, with a slash at the end.
std::string step_group(std::size_t step);
std::string grid_group(std::size_t grid);

// XDMF 3: at every time all grids with those of the fields that they have, stress as one scalar for
// each of datasets_of(). `heavy`: the file of fields, as the text names it.
void write_xdmf(std::ostream& out, const std::filesystem::path& heavy,
                const std::vector<double>& times, const std::vector<FieldGrid>& grids,
                const std::vector<std::string>& fields);

}  // namespace cbr
