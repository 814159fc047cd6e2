// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/io/gmsh_types.hpp"

#include <cassert>
#include <map>

#include "common/base/error.hpp"

namespace cbr {
namespace {

// Numbers and node orders: gmsh's manual, "MSH file format" and "Node ordering".
const std::vector<GmshType>& table() {
  static const std::vector<GmshType> types = {
      {15, 0, 1, {}, {}},
      {1, 1, 2, {}, {}},
      {8, 1, 3, {}, {}},
      {2, 2, 3, ElementType::tri3, {}},
      {9, 2, 6, ElementType::tri6, {}},
      {3, 2, 4, ElementType::quad4, {}},
      {16, 2, 8, ElementType::quad8, {}},
      {10, 2, 9, ElementType::quad9, {}},
      {4, 3, 4, ElementType::tet4, {}},
      // gmsh has the edge 2-3 before 1-3.
      {11, 3, 10, ElementType::tet10, {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}},
      {7, 3, 5, ElementType::pyramid5, {}},
      {6, 3, 6, ElementType::wedge6, {}},
      // gmsh's edges: 01 02 03 12 14 25 34 35 45
      {18, 3, 15, ElementType::wedge15, {0, 1, 2, 3, 4, 5, 6, 9, 7, 8, 10, 11, 12, 14, 13}},
      {5, 3, 8, ElementType::hex8, {}},
      // gmsh's edges: 01 03 04 12 15 23 26 37 45 47 56 67; then its faces: bottom, front, left,
      // right, back, top; the centre.
      {17, 3, 20, ElementType::hex20, {0,  1, 2,  3,  4,  5,  6,  7,  8,  11,
                                       13, 9, 10, 12, 14, 15, 16, 18, 19, 17}},
      {12, 3, 27, ElementType::hex27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  10, 12,
                                       14, 15, 16, 18, 19, 17, 26, 20, 25, 22, 23, 21, 24}},
  };
  return types;
}

}  // namespace

const GmshType* find_gmsh_type(int number) {
  for (const auto& type : table())
    if (type.number == number) return &type;
  return nullptr;
}

std::string gmsh_type_name(int number) {
  static const std::map<int, std::string> others = {
      {13, "Prism 18"},    {14, "Pyramid 14"},   {19, "Pyramid 13"},     {20, "Triangle 9"},
      {21, "Triangle 10"}, {26, "Line 4"},       {29, "Tetrahedron 20"}, {36, "Quadrilateral 16"},
      {90, "Prism 40"},    {92, "Hexahedron 64"}};
  const auto found = others.find(number);
  const std::string text = "number " + std::to_string(number);
  return found == others.end() ? text : "'" + found->second + "' (" + text + ")";
}

const GmshType& gmsh_type(ElementType type) {
  for (const auto& entry : table())
    if (entry.type == type) return entry;
  assert(false);
  return table().front();
}

std::string supported_gmsh_types() {
  std::vector<std::string> names;
  for (const auto& entry : table())
    if (entry.type) names.emplace_back(name(*entry.type));
  return join(names);
}

}  // namespace cbr
