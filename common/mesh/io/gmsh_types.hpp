// SPDX-License-Identifier: GPL-3.0-or-later
// gmsh's element types against ours, and its files. For the .cpp of this folder.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/types.hpp"
#include "common/mesh/element_type.hpp"

namespace cbr {

struct GmshType {
  int number = 0;  // gmsh's
  int dimension = 0, n_nodes = 0;
  std::optional<ElementType> type;  // none: points and lines
  // node i in Exodus order is gmsh's node order[i]; empty: the same
  std::vector<int> order;
};

const GmshType* find_gmsh_type(int number);  // nullptr when it is not supported
std::string gmsh_type_name(int number);      // also of types that are not supported
const GmshType& gmsh_type(ElementType type);
std::string supported_gmsh_types();  // "tri3, tri6, ..."

// A .msh file's contents as they stand in it: formats 2.2 and 4.1, text and binary. Read here and
// not by libgmsh, which crashes on damaged files of format 4.1, takes some that are cut short
// without a word, runs other text files as scripts of its own, and forgets which physical group an
// element of format 2 was in. The tests hold this reader to libgmsh's meaning of its files.
struct MshElement {
  Index id = 0;
  int type = 0;  // gmsh's, one that find_gmsh_type() finds
  int dimension = 0;
  Index entity = 0;       // geometrical
  Index group = 0;        // format 2: the physical group, 0: none
  std::size_t first = 0;  // of its nodes in MshFile::element_nodes
};

struct MshFile {
  double version = 0;
  bool binary = false;
  std::vector<Index> node_ids;
  std::vector<double> coordinates;  // 3 a node
  std::vector<MshElement> elements;
  std::vector<Index> element_nodes;  // ids, gmsh's order
  // format 4: (dimension, tag) -> physical groups
  std::map<std::pair<int, Index>, std::vector<Index>> groups_of_entity;
  // (dimension, physical tag)
  std::map<std::pair<int, Index>, std::string> group_names;
};

// InputError: not a .msh file, a format other than 2.x and 4.1, sections that are missing, cut
// short or unreadable, element types that are not supported, by name. Node ids that are not defined
// are left to the caller.
MshFile read_msh(const std::filesystem::path& file);

}  // namespace cbr
