// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes to be cut into domains: several element types on a warped lattice, also with elements
// omitted.
#pragma once

#include <functional>

#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test {

// Keeps the elements of block 0 whose cell (i, j, k) satisfies `keep`, and their sides.
inline Mesh with_cells(const Mesh& whole, std::array<Index, 3> n,
                       const std::function<bool(Index, Index, Index)>& keep) {
  Mesh mesh = whole;
  Block& block = mesh.blocks[0];
  std::vector<Index> rows, new_row(block.element_ids.size(), -1);
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    if (!keep(e % n[0], e / n[0] % n[1], e / n[0] / n[1])) continue;
    new_row[e] = static_cast<Index>(rows.size());
    rows.push_back(e);
  }
  block.connectivity = IndexTable(whole.blocks[0].connectivity(rows, Eigen::all));
  block.element_ids.clear();
  for (const Index e : rows) block.element_ids.push_back(whole.blocks[0].element_ids[e]);
  for (Sideset& set : mesh.sidesets) {
    std::vector<Side> sides;
    for (Side side : set.sides) {
      side.element = new_row[side.element];
      if (side.element >= 0) sides.push_back(side);
    }
    set.sides = sides;
  }
  mesh.nodesets.clear();
  return mesh;
}

// A comb: teeth of one cell's width in x, with gaps as wide, on a back of one layer in y.
inline Mesh comb_mesh(Index teeth, Index length) {
  const std::array<Index, 3> n = {2 * teeth - 1, length, 2};
  const Mesh box =
      box_mesh({n, {static_cast<double>(n[0]), static_cast<double>(length), 2}, {0, 0, 0}, 0.05});
  return with_cells(box, n, [](Index i, Index j, Index) { return j == 0 || i % 2 == 0; });
}

// Two blocks of m^3 cells with one common edge.
inline Mesh blocks_joined_at_an_edge(Index m) {
  const double size = 2.0 * static_cast<double>(m);
  const Mesh box = box_mesh({{2 * m, 2 * m, m}, {size, size, size / 2}, {0, 0, 0}, 0.05});
  return with_cells(box, {2 * m, 2 * m, m},
                    [m](Index i, Index j, Index) { return (i < m) == (j < m); });
}

// Each cell of 2 x 2 x 2 lattice steps as six tet10 (Kuhn's), so that all lattice nodes are used.
// Sideset x_min.
inline Mesh tet10_mesh(std::array<Index, 3> n, double skew) {
  const std::array<Index, 3> lattice = {2 * n[0], 2 * n[1], 2 * n[2]};
  Mesh mesh = box_mesh({lattice,
                        {2.0 * static_cast<double>(n[0]), 2.0 * static_cast<double>(n[1]),
                         2.0 * static_cast<double>(n[2])},
                        {0, 0, 0},
                        skew});
  const auto node = [&](const std::array<Index, 3>& x) {
    return x[0] + (lattice[0] + 1) * (x[1] + (lattice[1] + 1) * x[2]);
  };
  const std::array<std::array<std::size_t, 3>, 6> orders = {
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}};
  Block block{"tets", 1, ElementType::tet10, IndexTable(6 * n[0] * n[1] * n[2], 10), {}};
  Sideset x_min{"x_min", 1, {}};
  for (Index cell = 0; cell < n[0] * n[1] * n[2]; ++cell) {
    for (std::size_t o = 0; o < 6; ++o) {
      std::array<std::array<Index, 3>, 4> x;
      x[0] = {2 * (cell % n[0]), 2 * (cell / n[0] % n[1]), 2 * (cell / n[0] / n[1])};
      for (std::size_t a = 0; a < 3; ++a) {
        x[a + 1] = x[a];
        x[a + 1][orders[o][a]] += 2;
      }
      if (o >= 3) std::swap(x[2], x[3]);  // reverses the orientation
      const Index e = block.element_ids.size();
      const auto middle = [&](std::size_t a, std::size_t b) {
        return node({(x[a][0] + x[b][0]) / 2, (x[a][1] + x[b][1]) / 2, (x[a][2] + x[b][2]) / 2});
      };
      block.connectivity.row(e) << node(x[0]), node(x[1]), node(x[2]), node(x[3]), middle(0, 1),
          middle(1, 2), middle(0, 2), middle(0, 3), middle(1, 3), middle(2, 3);
      block.element_ids.push_back(e + 1);
      for (int side = 1; side <= 4; ++side) {
        const auto& corners = side_nodes(ElementType::tet10, side);
        if (std::all_of(corners.begin(), corners.begin() + 3, [&](int a) { return x[a][0] == 0; }))
          x_min.sides.push_back({0, e, side});
      }
    }
  }
  mesh.blocks = {block};
  mesh.sidesets = {x_min};
  mesh.nodesets.clear();
  return mesh;
}

// Columns of hexes, of wedge pairs, and of six pyramids around a node of their own. Sideset x_min
// on columns of hexes.
inline Mesh mixed_mesh(std::array<Index, 3> n, double skew) {
  Mesh mesh =
      box_mesh({n,
                {static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])},
                {0, 0, 0},
                skew});
  const Block all = mesh.blocks[0];
  std::array<std::vector<std::vector<Index>>, 3> rows;  // hexes, wedges, pyramids
  std::vector<Index> new_row(all.element_ids.size(), -1);
  for (Index e = 0; e < all.connectivity.rows(); ++e) {
    const auto v = [&](Index a) { return all.connectivity(e, a); };
    const Index kind = (e % n[0] + e / n[0] % n[1]) % 3;
    if (kind == 0) {
      new_row[e] = static_cast<Index>(rows[0].size());
      rows[0].push_back({v(0), v(1), v(2), v(3), v(4), v(5), v(6), v(7)});
    } else if (kind == 1) {
      rows[1].push_back({v(0), v(1), v(3), v(4), v(5), v(7)});
      rows[1].push_back({v(1), v(2), v(3), v(5), v(6), v(7)});
    } else {
      const Index center = mesh.coordinates.rows();
      mesh.coordinates.conservativeResize(center + 1, 3);
      mesh.coordinates.row(center) =
          mesh.coordinates(all.connectivity.row(e), Eigen::all).colwise().mean();
      mesh.node_ids.push_back(10 * center + 7);
      for (int side = 1; side <= 6; ++side) {
        // outward, so that the base is reversed
        const auto& face = side_nodes(ElementType::hex8, side);
        rows[2].push_back({v(face[0]), v(face[3]), v(face[2]), v(face[1]), center});
      }
    }
  }
  mesh.blocks.clear();
  const std::array<ElementType, 3> types = {ElementType::hex8, ElementType::wedge6,
                                            ElementType::pyramid5};
  Index id = 0;
  for (std::size_t b = 0; b < 3; ++b) {
    Block block{"block " + std::to_string(b),
                static_cast<Index>(b) + 1,
                types[b],
                IndexTable(std::ssize(rows[b]), n_nodes(types[b])),
                {}};
    for (std::size_t e = 0; e < rows[b].size(); ++e) {
      for (std::size_t a = 0; a < rows[b][e].size(); ++a)
        block.connectivity(static_cast<Index>(e), static_cast<Index>(a)) = rows[b][e][a];
      block.element_ids.push_back(++id);
    }
    mesh.blocks.push_back(block);
  }
  Sideset x_min{"x_min", 1, {}};
  for (const Side& side : mesh.sidesets[0].sides) {
    const Index row = new_row[side.element];
    if (row >= 0) x_min.sides.push_back({0, row, side.side});
  }
  mesh.sidesets = {x_min};
  mesh.nodesets.clear();
  return mesh;
}

}  // namespace cbr::test
