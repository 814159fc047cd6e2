// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/element_type.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace cbr {
namespace {

struct Topology {
  std::string_view name;
  int n_nodes, n_corners, dimension;
  std::vector<std::vector<int>> sides;
};

// Node and side numbers as in the Exodus II manual (SAND92-2137), minus one; in the order of the
// enumeration.
const std::array<Topology, 13>& topologies() {
  static const std::array<Topology, 13> table = {{
      {"tri3", 3, 3, 2, {}},
      {"tri6", 6, 3, 2, {}},
      {"quad4", 4, 4, 2, {}},
      {"quad8", 8, 4, 2, {}},
      {"quad9", 9, 4, 2, {}},
      {"tet4", 4, 4, 3, {{0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 2, 1}}},
      {"tet10",
       10,
       4,
       3,
       {{0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {0, 3, 2, 7, 9, 6}, {0, 2, 1, 6, 5, 4}}},
      {"pyramid5", 5, 5, 3, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {0, 4, 3}, {0, 3, 2, 1}}},
      {"wedge6", 6, 6, 3, {{0, 1, 4, 3}, {1, 2, 5, 4}, {0, 3, 5, 2}, {0, 2, 1}, {3, 4, 5}}},
      {"wedge15",
       15,
       6,
       3,
       {{0, 1, 4, 3, 6, 10, 12, 9},
        {1, 2, 5, 4, 7, 11, 13, 10},
        {0, 3, 5, 2, 9, 14, 11, 8},
        {0, 2, 1, 8, 7, 6},
        {3, 4, 5, 12, 13, 14}}},
      {"hex8",
       8,
       8,
       3,
       {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {0, 4, 7, 3}, {0, 3, 2, 1}, {4, 5, 6, 7}}},
      {"hex20",
       20,
       8,
       3,
       {{0, 1, 5, 4, 8, 13, 16, 12},
        {1, 2, 6, 5, 9, 14, 17, 13},
        {2, 3, 7, 6, 10, 15, 18, 14},
        {0, 4, 7, 3, 12, 19, 15, 11},
        {0, 3, 2, 1, 11, 10, 9, 8},
        {4, 5, 6, 7, 16, 17, 18, 19}}},
      {"hex27",
       27,
       8,
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
  const auto found = std::find_if(topologies().begin(), topologies().end(),
                                  [&](const Topology& of) { return of.n_nodes == n_nodes(kind); });
  return found->name;
}

int n_nodes(ElementType type) { return topology(type).n_nodes; }
int n_nodes(FaceKind kind) { return static_cast<int>(kind); }
int dimension(ElementType type) { return topology(type).dimension; }
int n_sides(ElementType type) { return static_cast<int>(topology(type).sides.size()); }

const std::vector<int>& side_nodes(ElementType type, int side) {
  assert(side >= 1 && side <= n_sides(type));
  return topology(type).sides[side - 1];
}

FaceKind side_kind(ElementType type, int side) {
  return static_cast<FaceKind>(side_nodes(type, side).size());
}

int n_corners(ElementType type) { return topology(type).n_corners; }
int n_corners(FaceKind kind) { return kind == FaceKind::tri3 || kind == FaceKind::tri6 ? 3 : 4; }

const std::vector<int>& mirrored_order(ElementType type) {
  // Reflected in its first reference coordinate (the triangle families: nodes 2 and 3 swapped):
  // positive volume again.
  static const std::array<std::vector<int>, 13> table = {{
      {0, 2, 1},
      {0, 2, 1, 5, 4, 3},
      {0, 3, 2, 1},
      {0, 3, 2, 1, 7, 6, 5, 4},
      {0, 3, 2, 1, 7, 6, 5, 4, 8},
      {0, 2, 1, 3},
      {0, 2, 1, 3, 6, 5, 4, 7, 9, 8},
      {0, 3, 2, 1, 4},
      {0, 2, 1, 3, 5, 4},
      {0, 2, 1, 3, 5, 4, 8, 7, 6, 9, 11, 10, 14, 13, 12},
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
  for (const int local : side_nodes(type, side)) nodes.push_back(order[local]);
  for (int s = 1; s <= n_sides(type); ++s)
    if (std::is_permutation(nodes.begin(), nodes.end(), side_nodes(type, s).begin(),
                            side_nodes(type, s).end()))
      return s;
  assert(false);
  return side;
}

}  // namespace cbr
