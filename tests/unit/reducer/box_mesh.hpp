// SPDX-License-Identifier: GPL-3.0-or-later
// A block of hexes with a sideset on each face.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/fem/assembly.hpp"
#include "common/mesh/mesh.hpp"

namespace cbr::test {

struct BoxSides {
  std::array<Index, 3> n = {4, 3, 2};  // elements
  std::array<double, 3> size = {4, 3, 2};
  std::array<double, 3> origin = {0, 0, 0};  // of the corner
  // displacement of interior and surface nodes, relative to an element
  double skew = 0;
};

// Sidesets x_min, x_max, y_min, ..., surface (all six); nodesets corner (1 node), edge (the nodes
// of the z edge at the origin).
inline Mesh box_mesh(const BoxSides& box) {
  const Index nx = box.n[0], ny = box.n[1], nz = box.n[2];
  Mesh mesh;
  const auto node = [&](Index i, Index j, Index k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  mesh.coordinates.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  for (Index k = 0; k <= nz; ++k) {
    for (Index j = 0; j <= ny; ++j) {
      for (Index i = 0; i <= nx; ++i) {
        const std::array<Index, 3> at = {i, j, k};
        for (std::size_t d = 0; d < 3; ++d) {
          const double h = box.size[d] / static_cast<double>(box.n[d]);
          const double wave =
              std::sin(static_cast<double>(3 * i + 5 * j + 7 * k) + static_cast<double>(d));
          mesh.coordinates(node(i, j, k), static_cast<Index>(d)) =
              box.origin[d] + h * (static_cast<double>(at[d]) + box.skew * wave);
        }
        mesh.node_ids.push_back(10 * node(i, j, k) + 7);
      }
    }
  }
  Block block;
  block.name = "solid";
  block.id = 1;
  block.connectivity.resize(nx * ny * nz, 8);
  std::array<Sideset, 6> faces;
  const std::array<const char*, 6> names = {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};
  const std::array<int, 6> sides = {4, 2, 1, 3, 5, 6};  // of a hex8 in Exodus II
  Sideset surface{"surface", 7, {}};
  for (Index k = 0; k < nz; ++k) {
    for (Index j = 0; j < ny; ++j) {
      for (Index i = 0; i < nx; ++i) {
        const Index e = block.element_ids.size();
        block.connectivity.row(e) << node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k),
            node(i, j + 1, k), node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1),
            node(i, j + 1, k + 1);
        block.element_ids.push_back(e + 1);
        const std::array<bool, 6> on = {i == 0,      i == nx - 1, j == 0,
                                        j == ny - 1, k == 0,      k == nz - 1};
        for (std::size_t f = 0; f < 6; ++f) {
          if (!on[f]) continue;
          faces[f].sides.push_back({0, e, sides[f]});
          surface.sides.push_back({0, e, sides[f]});
        }
      }
    }
  }
  mesh.blocks.push_back(block);
  for (std::size_t f = 0; f < 6; ++f) {
    faces[f].name = names[f];
    faces[f].id = static_cast<Index>(f) + 1;
    mesh.sidesets.push_back(faces[f]);
  }
  mesh.sidesets.push_back(surface);
  mesh.nodesets.push_back({"corner", 1, {0}});
  Nodeset edge{"edge", 2, {}};
  for (Index k = 0; k <= nz; ++k) edge.nodes.push_back(node(0, 0, k));
  mesh.nodesets.push_back(edge);
  return mesh;
}

// Both meshes in one, side by side, without common nodes.
inline Mesh both(const Mesh& a, const Mesh& b) {
  Mesh mesh = a;
  const Index n = a.coordinates.rows(), elements = a.blocks[0].connectivity.rows();
  mesh.coordinates.conservativeResize(n + b.coordinates.rows(), 3);
  mesh.coordinates.bottomRows(b.coordinates.rows()) = b.coordinates;
  for (const Index id : b.node_ids) mesh.node_ids.push_back(id + 100000);
  Block block = b.blocks[0];
  block.name = "second";
  block.id = 2;
  block.connectivity.array() += n;
  for (Index& id : block.element_ids) id += elements;
  mesh.blocks.push_back(block);
  for (Sideset set : b.sidesets) {
    set.name += "_2";
    set.id += 100;
    for (Side& side : set.sides) side.block = 1;
    mesh.sidesets.push_back(set);
  }
  return mesh;
}

// T1 of the paper: 0.0508 x 0.0254 x 0.0381 m, 20 x 10 x 15 hexes.
inline BoxSides paper_block(Index nx = 20, Index ny = 10, Index nz = 15) {
  return {{nx, ny, nz}, {0.0508, 0.0254, 0.0381}, {-0.0254, -0.0127, -0.01905}, 0};
}
inline Material paper_steel() { return {5.17e12, 0.3, 7836}; }

inline std::vector<BlockProperties> properties(const Mesh& mesh, const Material& material) {
  return std::vector<BlockProperties>(mesh.blocks.size(),
                                      BlockProperties{material, HexFormulation::incompatible});
}

}  // namespace cbr::test
