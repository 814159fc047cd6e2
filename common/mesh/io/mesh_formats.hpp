// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/mesh/io: meshes in the files of other codes.
//
// The formats of read_mesh and write_mesh, and shared code of their readers. For the .cpp of this
// folder.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace cbr {

// What to do with a file that looks like a mesh or a geometry of another program by its suffix;
// empty when it does not.
std::string foreign_mesh_cure(const std::filesystem::path& file);

Mesh read_gmsh(const std::filesystem::path& file);
// Marks by which files of write_mesh are recognised.
inline constexpr const char *gmsh_mark = "Written by cbr\n", *exodus_mesh_title = "cbr";
// The writers write to `file` as it is and call it `where` in messages.
void write_gmsh(const Mesh& mesh, const std::filesystem::path& file, const std::string& where);
Mesh read_exodus(const std::filesystem::path& file);
Mesh read_abaqus_mesh(const std::filesystem::path& file);
Mesh read_nastran_mesh(const std::filesystem::path& file);
Mesh read_med(const std::filesystem::path& file);
Mesh read_with_gmsh(const std::filesystem::path& file);  // RunError: there is no program gmsh
void write_exodus(const Mesh& mesh, const std::filesystem::path& file, const std::string& where);

// The sides of volume elements by their corner nodes; only sides whose corners are all `wanted`
// (one flag per node), because all sides of a large mesh would take more memory than the mesh.
class SideLookup {
 public:
  SideLookup(const Mesh& mesh, const std::vector<bool>& wanted);

  // The side with these corners (3 or 4), or one with element = -1. A face between two volume
  // elements belongs to both: the one from which `corners` looks outwards is chosen, so the order
  // of the face's nodes decides; failing that the first one in the order of blocks and elements.
  Side find(const std::vector<Index>& corners) const;

 private:
  struct Entry {
    std::array<Index, 4> key;  // ascending; -1 first for a triangle
    Side side;
  };
  const Mesh& mesh_;
  std::vector<Entry> entries_;  // by key, then block, element, side
};

}  // namespace cbr
