// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/element_type.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace cbr {
namespace {

struct Topology {
  std::string_view name;
  int n_nodes, dimension;
  std::vector<std::vector<int>> sides;
};

// Node and side numbers as in the Exodus II manual (SAND92-2137), minus one; in the order of the
// enumeration.
const std::array<Topology, 12>& topologies() {
  static const std::array<Topology, 12> table = {{
      {"tri3", 3, 2, {}},
      {"tri6", 6, 2, {}},
      {"quad4", 4, 2, {}},
      {"quad8", 8, 2, {}},
      {"quad9", 9, 2, {}},
      {"tet4", 4, 3, {{0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 2, 1}}},
      {"tet10",
       10,
       3,
       {{0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {0, 3, 2, 7, 9, 6}, {0, 2, 1, 6, 5, 4}}},
      {"pyramid5", 5, 3, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {0, 4, 3}, {0, 3, 2, 1}}},
      {"wedge6", 6, 3, {{0, 1, 4, 3}, {1, 2, 5, 4}, {0, 3, 5, 2}, {0, 2, 1}, {3, 4, 5}}},
      {"hex8",
       8,
       3,
       {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {0, 4, 7, 3}, {0, 3, 2, 1}, {4, 5, 6, 7}}},
      {"hex20",
       20,
       3,
       {{0, 1, 5, 4, 8, 13, 16, 12},
        {1, 2, 6, 5, 9, 14, 17, 13},
        {2, 3, 7, 6, 10, 15, 18, 14},
        {0, 4, 7, 3, 12, 19, 15, 11},
        {0, 3, 2, 1, 11, 10, 9, 8},
        {4, 5, 6, 7, 16, 17, 18, 19}}},
      {"hex27",
       27,
       3,
       {{0, 1, 5, 4, 8, 13, 16, 12, 25},
        {1, 2, 6, 5, 9, 14, 17, 13, 24},
        {2, 3, 7, 6, 10, 15, 18, 14, 26},
        {0, 4, 7, 3, 12, 19, 15, 11, 23},
        {0, 3, 2, 1, 11, 10, 9, 8, 21},
        {4, 5, 6, 7, 16, 17, 18, 19, 22}}},
  }};
  return table;
}

const Topology& topology(ElementType type) { return topologies()[static_cast<std::size_t>(type)]; }

}  // namespace

std::string_view name(ElementType type) { return topology(type).name; }

std::string_view name(FaceKind kind) {
  switch (kind) {
    case FaceKind::tri3:
      return "tri3";
    case FaceKind::quad4:
      return "quad4";
    case FaceKind::tri6:
      return "tri6";
    case FaceKind::quad8:
      return "quad8";
    case FaceKind::quad9:
      return "quad9";
  }
  assert(false);
  return "";
}

int n_nodes(ElementType type) { return topology(type).n_nodes; }
int n_nodes(FaceKind kind) { return static_cast<int>(kind); }
int dimension(ElementType type) { return topology(type).dimension; }
int n_sides(ElementType type) { return static_cast<int>(topology(type).sides.size()); }

const std::vector<int>& side_nodes(ElementType type, int side) {
  assert(side >= 1 && side <= n_sides(type));
  return topology(type).sides[static_cast<std::size_t>(side - 1)];
}

FaceKind side_kind(ElementType type, int side) {
  return static_cast<FaceKind>(side_nodes(type, side).size());
}

int n_corners(ElementType type) {
  switch (type) {
    case ElementType::tri3:
    case ElementType::tri6:
      return 3;
    case ElementType::quad4:
    case ElementType::quad8:
    case ElementType::quad9:
    case ElementType::tet4:
    case ElementType::tet10:
      return 4;
    case ElementType::pyramid5:
      return 5;
    case ElementType::wedge6:
      return 6;
    case ElementType::hex8:
    case ElementType::hex20:
    case ElementType::hex27:
      return 8;
  }
  assert(false);
  return 0;
}

int n_corners(FaceKind kind) { return kind == FaceKind::tri3 || kind == FaceKind::tri6 ? 3 : 4; }

const std::vector<int>& mirrored_order(ElementType type) {
  // Reflected in its first reference coordinate (the triangle families: nodes 2 and 3 swapped):
  // positive volume again.
  static const std::array<std::vector<int>, 12> table = {{
      {0, 2, 1},
      {0, 2, 1, 5, 4, 3},
      {0, 3, 2, 1},
      {0, 3, 2, 1, 7, 6, 5, 4},
      {0, 3, 2, 1, 7, 6, 5, 4, 8},
      {0, 2, 1, 3},
      {0, 2, 1, 3, 6, 5, 4, 7, 9, 8},
      {0, 3, 2, 1, 4},
      {0, 2, 1, 3, 5, 4},
      {0, 3, 2, 1, 4, 7, 6, 5},
      {0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 12, 15, 14, 13, 19, 18, 17, 16},
      // The transposition x <-> y of the reference element also exchanges the left and front, right
      // and back face nodes.
      {0,  3,  2,  1,  4,  7,  6,  5,  11, 10, 9,  8,  12, 15,
       14, 13, 19, 18, 17, 16, 20, 21, 22, 25, 26, 23, 24},
  }};
  return table[static_cast<std::size_t>(type)];
}

int mirrored_side(ElementType type, int side) {
  const auto& order = mirrored_order(type);
  std::vector<int> nodes;
  for (const int local : side_nodes(type, side))
    nodes.push_back(order[static_cast<std::size_t>(local)]);
  for (int s = 1; s <= n_sides(type); ++s)
    if (std::is_permutation(nodes.begin(), nodes.end(), side_nodes(type, s).begin(),
                            side_nodes(type, s).end()))
      return s;
  assert(false);
  return side;
}

}  // namespace cbr
