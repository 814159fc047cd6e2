// SPDX-License-Identifier: GPL-3.0-or-later
// gmsh's element types against ours. For the .cpp of this folder.
#pragma once

#include <optional>
#include <string>
#include <vector>

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

}  // namespace cbr
