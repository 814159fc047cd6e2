// SPDX-License-Identifier: GPL-3.0-or-later
// Small meshes for several tests, without files.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/block_mesh.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::test {

inline constexpr std::array<ElementType, 13> all_types = {
    ElementType::tri3,   ElementType::tri6,    ElementType::quad4, ElementType::quad8,
    ElementType::quad9,  ElementType::tet4,    ElementType::tet10, ElementType::pyramid5,
    ElementType::wedge6, ElementType::wedge15, ElementType::hex8,  ElementType::hex20,
    ElementType::hex27};

// Each node of an element as the mean of corners, which defines the node order independently of the
// tables under test. From the figures of the Exodus II manual, numbers from 0.
inline std::vector<std::vector<int>> node_corners(ElementType type) {
  const auto corners = [](int n) {
    std::vector<std::vector<int>> list;
    for (int i = 0; i < n; ++i) list.push_back({i});
    return list;
  };
  const auto with = [&](int n, const std::vector<std::vector<int>>& more) {
    auto list = corners(n);
    list.insert(list.end(), more.begin(), more.end());
    return list;
  };
  const std::vector<std::vector<int>> hex_edges = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 5},
                                                   {2, 6}, {3, 7}, {4, 5}, {5, 6}, {6, 7}, {7, 4}};
  switch (type) {
    case ElementType::tri3:
      return corners(3);
    case ElementType::tri6:
      return with(3, {{0, 1}, {1, 2}, {2, 0}});
    case ElementType::quad4:
      return corners(4);
    case ElementType::quad8:
      return with(4, {{0, 1}, {1, 2}, {2, 3}, {3, 0}});
    case ElementType::quad9:
      return with(4, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 1, 2, 3}});
    case ElementType::tet4:
      return corners(4);
    case ElementType::tet10:
      return with(4, {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}});
    case ElementType::pyramid5:
      return corners(5);
    case ElementType::wedge6:
      return corners(6);
    case ElementType::wedge15:
      return with(6, {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 4}, {2, 5}, {3, 4}, {4, 5}, {5, 3}});
    case ElementType::hex8:
      return corners(8);
    case ElementType::hex20:
      return with(8, hex_edges);
    case ElementType::hex27: {
      auto list = with(8, hex_edges);
      for (const auto& more : std::vector<std::vector<int>>{{0, 1, 2, 3, 4, 5, 6, 7},
                                                            {0, 1, 2, 3},
                                                            {4, 5, 6, 7},
                                                            {0, 3, 7, 4},
                                                            {1, 2, 6, 5},
                                                            {0, 1, 5, 4},
                                                            {2, 3, 7, 6}})
        list.push_back(more);
      return list;
    }
  }
  return {};
}

// Coordinates of a straight-sided element with the given corners, in Exodus order.
inline Points element_points(ElementType type, const Points& corners) {
  const auto parents = node_corners(type);
  Points X = Points::Zero(static_cast<Index>(parents.size()), 3);
  for (std::size_t i = 0; i < parents.size(); ++i)
    for (const int corner : parents[i])
      X.row(static_cast<Index>(i)) += corners.row(corner) / static_cast<double>(parents[i].size());
  return X;
}

// Corners of a slightly skew, right-handed element, without symmetry that could hide a wrong order.
inline Points skew_corners(ElementType type) {
  Points X(n_corners(type), 3);
  switch (n_corners(type)) {
    case 3:
      X << 0, 0, 0, 2, 0.1, 0, 0.2, 1, 0.3;
      break;
    case 4:
      if (dimension(type) == 2)
        X << 0, 0, 0, 2, 0.1, 0, 2.2, 1, 0, 0.2, 1.3, 0.1;
      else
        X << 0, 0, 0, 2, 0.1, 0, 0.2, 1, 0.3, 0.4, 0.3, 1.5;
      break;
    case 5:
      X << 0, 0, 0, 2, 0.1, 0, 2.2, 1, 0, 0.2, 1.3, 0, 1, 0.7, 1.4;
      break;
    case 6:
      X << 0, 0, 0, 2, 0.1, 0, 0.2, 1, 0.1, 0.1, 0, 1.5, 2.2, 0.2, 1.4, 0.3, 1.1, 1.7;
      break;
    default:
      X << 0, 0, 0, 2, 0.1, 0, 2.2, 1, 0.1, 0.2, 1.3, 0, 0.1, 0.1, 1.5, 2.1, 0, 1.6, 2.3, 1.2, 1.7,
          0.1, 1.1, 1.4;
  }
  return X;
}

// One element of each type, not connected, each a block; volume elements with a sideset of every
// side, and a nodeset of corners.
inline Mesh zoo() {
  Mesh mesh;
  std::vector<Points> parts;
  Index n = 0;
  for (const ElementType type : all_types) {
    Points X = element_points(type, skew_corners(type));
    X.col(0).array() += 3.0 * static_cast<double>(parts.size());
    Block block;
    block.name = "block of " + std::string(name(type));
    block.id = 10 + static_cast<Index>(parts.size());
    block.type = type;
    block.connectivity.resize(1, n_nodes(type));
    for (Index i = 0; i < X.rows(); ++i) block.connectivity(0, i) = n + i;
    block.element_ids = {1000 - 7 * static_cast<Index>(parts.size())};
    mesh.blocks.push_back(block);
    n += X.rows();
    parts.push_back(X);
  }
  mesh.coordinates.resize(n, 3);
  Index row = 0;
  for (const auto& X : parts) {
    mesh.coordinates.middleRows(row, X.rows()) = X;
    row += X.rows();
  }
  for (Index i = 0; i < n; ++i) mesh.node_ids.push_back(5 + 3 * i);
  Sideset all{"all sides", 4, {}}, first{"first sides", 9, {}};
  for (Index b = 0; b < static_cast<Index>(mesh.blocks.size()); ++b) {
    const ElementType type = mesh.blocks[b].type;
    for (int s = 1; s <= n_sides(type); ++s) all.sides.push_back({b, 0, s});
    if (n_sides(type) > 0) first.sides.push_back({b, 0, 1});
  }
  mesh.sidesets = {all, first};
  mesh.nodesets = {{"corners", 2, {0, 9, 30}}, {"all sides", 3, {1, 2}}};
  return mesh;
}

// n_x x n_y x n_z unit hexes with sidesets x_min, x_max.
inline Mesh brick(Index nx, Index ny, Index nz) {
  const Vector3 size(static_cast<double>(nx), static_cast<double>(ny), static_cast<double>(nz));
  Mesh mesh = block_mesh({{nx, ny, nz}, size});
  mesh.blocks[0].name = "solid";
  mesh.sidesets.resize(2);
  return mesh;
}

inline void expect_equal(const Mesh& a, const Mesh& b, double tolerance = 0) {
  EXPECT_EQ(a.node_ids, b.node_ids);
  ASSERT_EQ(a.coordinates.rows(), b.coordinates.rows());
  EXPECT_LE((a.coordinates - b.coordinates).lpNorm<Eigen::Infinity>(), tolerance);
  ASSERT_EQ(a.blocks.size(), b.blocks.size());
  for (const auto& block : a.blocks) {
    SCOPED_TRACE(block.name);
    const Index other = find_block(b, block.name);
    ASSERT_GE(other, 0);
    const Block& found = b.blocks[other];
    EXPECT_EQ(block.id, found.id);
    EXPECT_EQ(block.type, found.type);
    EXPECT_EQ(block.element_ids, found.element_ids);
    EXPECT_EQ(block.connectivity, found.connectivity);
  }
  // Sides by element id and nodes, in any order: a file may reorder blocks and faces.
  const auto sides = [](const Mesh& mesh, const Sideset& set) {
    std::set<std::tuple<Index, int, std::vector<Index>>> all;
    for (const Side& s : set.sides)
      all.insert({mesh.blocks[s.block].element_ids[s.element], s.side, nodes_of_side(mesh, s)});
    return all;
  };
  ASSERT_EQ(a.sidesets.size(), b.sidesets.size());
  for (const auto& set : a.sidesets) {
    SCOPED_TRACE(set.name);
    const Index other = find_sideset(b, set.name);
    ASSERT_GE(other, 0);
    EXPECT_EQ(set.id, b.sidesets[other].id);
    EXPECT_EQ(set.sides.size(), b.sidesets[other].sides.size());
    EXPECT_EQ(sides(a, set), sides(b, b.sidesets[other]));
  }
  ASSERT_EQ(a.nodesets.size(), b.nodesets.size());
  for (const auto& set : a.nodesets) {
    SCOPED_TRACE(set.name);
    const Index other = find_nodeset(b, set.name);
    ASSERT_GE(other, 0);
    EXPECT_EQ(set.id, b.nodesets[other].id);
    EXPECT_EQ(set.nodes, b.nodesets[other].nodes);
  }
}

}  // namespace cbr::test
