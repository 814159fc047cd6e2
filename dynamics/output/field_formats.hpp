// SPDX-License-Identifier: GPL-3.0-or-later
// Fields for viewers: one Exodus II file (`output.format: exodus`), or XDMF text beside the file of
// fields.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "dynamics/output/field_grids.hpp"

namespace cbr {

// Prefix of the title of Exodus II files. A later run may replace files with it.
inline constexpr const char* exodus_title = "cbr-dyn";

// Writes `target`, the whole file or nothing, from the file of fields `heavy` (docs/formats.md,
// "Fields"). A grid becomes a block. Vectors become NAME_x, NAME_y, NAME_z. Ids are those of the
// mesh. For points of further meshes or superelements a multiple of a power of ten is added, so
// that ids are unique. InputError: no grid. RunError: disk errors.
void write_exodus_fields(const std::filesystem::path& heavy, const std::vector<double>& times,
                         const std::vector<FieldGrid>& grids,
                         const std::vector<std::string>& fields,
                         const std::filesystem::path& target);

// Groups of the file of fields, with a trailing slash.
std::string step_group(std::size_t step);
std::string grid_group(std::size_t grid);

// Writes XDMF 3: at each time all grids with their fields, stress as one scalar per dataset of
// datasets_of(). `heavy`: the file of fields, as named in the text.
void write_xdmf(std::ostream& out, const std::filesystem::path& heavy,
                const std::vector<double>& times, const std::vector<FieldGrid>& grids,
                const std::vector<std::string>& fields);

}  // namespace cbr
