// SPDX-License-Identifier: GPL-3.0-or-later
// A block of hexes with a sideset on each face.
#pragma once

#include <array>
#include <functional>

#include "common/mesh/mesh.hpp"

namespace cbr::test {

// A block of hex8 from the origin to `size`, n elements along each edge, then moved by `map` (which
// must not invert elements). Block "block"; sidesets x_min, x_max, y_min, y_max, z_min, z_max for
// contact, loads and supports.
struct BlockShape {
  std::array<Index, 3> n{1, 1, 1};
  Vector3 size = Vector3::Ones();
  std::function<Vector3(const Vector3&)> map = {};
};
inline Mesh block_mesh(const BlockShape& shape) {
  // Exodus: sides 1 to 4 go round the element's edges from node 1, 5 is below, 6 above.
  struct Face {
    const char* name;
    int axis;
    bool upper;
    int side;
  };
  constexpr Face faces[] = {{"x_min", 0, false, 4}, {"x_max", 0, true, 2},  {"y_min", 1, false, 1},
                            {"y_max", 1, true, 3},  {"z_min", 2, false, 5}, {"z_max", 2, true, 6}};
  const auto& n = shape.n;
  Mesh mesh;
  mesh.coordinates.resize((n[0] + 1) * (n[1] + 1) * (n[2] + 1), 3);
  const auto node = [&](Index i, Index j, Index k) {
    return i + (n[0] + 1) * (j + (n[1] + 1) * k);
  };
  Block block;
  block.name = "block";
  block.id = 1;
  block.type = ElementType::hex8;
  block.connectivity.resize(n[0] * n[1] * n[2], 8);
  for (const Face& face : faces)
    mesh.sidesets.push_back({face.name, static_cast<Index>(mesh.sidesets.size()) + 1, {}});
  Index e = 0;
  for (Index k = 0; k <= n[2]; ++k) {
    for (Index j = 0; j <= n[1]; ++j) {
      for (Index i = 0; i <= n[0]; ++i) {
        const Vector3 x = shape.size.cwiseProduct(
            Vector3(double(i) / double(n[0]), double(j) / double(n[1]), double(k) / double(n[2])));
        mesh.coordinates.row(node(i, j, k)) = (shape.map ? shape.map(x) : x).transpose();
        mesh.node_ids.push_back(node(i, j, k) + 1);
        if (i == n[0] || j == n[1] || k == n[2]) continue;
        block.connectivity.row(e) << node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k),
            node(i, j + 1, k), node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1),
            node(i, j + 1, k + 1);
        block.element_ids.push_back(e + 1);
        const Index at[] = {i, j, k};
        for (std::size_t f = 0; f < std::size(faces); ++f)
          if (at[faces[f].axis] == (faces[f].upper ? n[faces[f].axis] - 1 : 0))
            mesh.sidesets[f].sides.push_back({0, e, faces[f].side});
        ++e;
      }
    }
  }
  mesh.blocks.push_back(std::move(block));
  return mesh;
}

// All six faces of such a block.
inline Sideset surface_of(const Mesh& block, Index id) {
  Sideset all{"surface", id, {}};
  for (std::size_t f = 0; f < 6; ++f)
    all.sides.insert(all.sides.end(), block.sidesets[f].sides.begin(),
                     block.sidesets[f].sides.end());
  return all;
}

}  // namespace cbr::test
