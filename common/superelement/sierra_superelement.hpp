// SPDX-License-Identifier: GPL-3.0-or-later
// Sierra/SD's superelement files (netCDF-3, whatever their suffix), read for comparison and import,
// and written for export. No face is stored in them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

struct SierraSuperelement {
  // n x n in the file's order: first the modes, then the interface dofs
  Matrix Kr, Mr;
  Index n_modes = 0;               // NumEig
  std::vector<Index> dof_node;     // per interface dof (n - n_modes): the mesh's node id
  std::vector<int> dof_component;  // 0 1 2 = x y z, 3 4 5 = rotations
  std::vector<Index> node_ids;
  Points coordinates;  // one row per node id
  Matrix output_map;   // OTM of older files: 6 rows per output node x n; else empty
  std::vector<Index> output_nodes;
  bool has_damping = false;  // Cr of newer files has an entry that is not 0; it is not read
};

// newer (Sierra/SD 5): modes with (0, 0) in cbmap; coordx, coordy, coordz; Cr. older (Salinas):
// cbmap of the interface dofs alone; coord; no Cr. Both have node set 1 of all nodes.
enum class SierraLayout { newer, older };

// RunError of the disk; InputError for ids beyond 32 bits. `where` stands for the file in messages.
// OTM is not written.
void write_sierra_superelement(const SierraSuperelement& s, SierraLayout layout,
                               const std::filesystem::path& file, const std::string& where);

// InputError: no netCDF file, Kr, Mr or cbmap missing or of a shape that does not fit the others.
SierraSuperelement read_sierra_superelement(const std::filesystem::path& file);

}  // namespace cbr
