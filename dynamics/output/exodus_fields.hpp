// SPDX-License-Identifier: GPL-3.0-or-later
// Fields as one Exodus II file, for `output.format: exodus`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynamics/output/field_grids.hpp"

namespace cbr {

// Prefix of the title of these files. A later run may replace files with it.
inline constexpr const char* exodus_title = "cbr-dyn";

// Writes `target`, the whole file or nothing, from the file of fields `heavy` (docs/formats.md,
// "Fields"). A grid becomes a block. Vectors become NAME_x, NAME_y, NAME_z. Ids are those of the
// mesh. For points of further meshes or superelements a multiple of a power of ten is added, so
// that ids are unique. InputError: no grid. RunError: disk errors.
void write_exodus_fields(const std::filesystem::path& heavy, const std::vector<double>& times,
                         const std::vector<FieldGrid>& grids,
                         const std::vector<std::string>& fields,
                         const std::filesystem::path& target);

}  // namespace cbr
