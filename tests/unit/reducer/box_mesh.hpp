// SPDX-License-Identifier: GPL-3.0-or-later
// Blocks of hexes, skew, joined, and that of the paper.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/fem/assembly.hpp"
#include "tests/support/block_mesh.hpp"

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
  const auto moved = [&](const Vector3& x) {
    Vector3 at, y;
    for (Index d = 0; d < 3; ++d)
      at[d] = std::round(x[d] / box.size[d] * static_cast<double>(box.n[d]));
    for (Index d = 0; d < 3; ++d) {
      const double wave = std::sin(3 * at[0] + 5 * at[1] + 7 * at[2] + static_cast<double>(d));
      y[d] =
          box.origin[d] + box.size[d] / static_cast<double>(box.n[d]) * (at[d] + box.skew * wave);
    }
    return y;
  };
  Mesh mesh = block_mesh({box.n, Eigen::Map<const Vector3>(box.size.data()), moved});
  mesh.blocks[0].name = "solid";
  for (Index& id : mesh.node_ids) id = 10 * id - 3;
  mesh.sidesets.push_back(surface_of(mesh, 7));
  Nodeset edge{"edge", 2, {}};
  for (Index k = 0; k <= box.n[2]; ++k) edge.nodes.push_back(k * (box.n[0] + 1) * (box.n[1] + 1));
  mesh.nodesets = {{"corner", 1, {0}}, edge};
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
