// SPDX-License-Identifier: GPL-3.0-or-later
// Fields as one Exodus II file, for `output.format: exodus`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynamics/output/field_grids.hpp"

namespace cbr {

// Begins the title of these files, by which a later run knows that it may replace one.
inline constexpr const char* exodus_title = "cbr-dyn";

// Writes `target`, whole or not at all, from the file of fields `heavy` (docs/formats.md,
// "Fields"). A grid is a block. Vectors become NAME_x, NAME_y, NAME_z. Ids are those of the mesh;
// points of the second, third, ... mesh or superelement get a power of ten on top, so that no two
// are alike. InputError: no grid. RunError: of the disk.
void write_exodus_fields(const std::filesystem::path& heavy, const std::vector<double>& times,
                         const std::vector<FieldGrid>& grids,
                         const std::vector<std::string>& fields,
                         const std::filesystem::path& target);

}  // namespace cbr
