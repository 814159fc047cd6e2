// SPDX-License-Identifier: GPL-3.0-or-later
// Boxes meshed with any volume element, for the tests of elements, assembly and convergence.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "common/fem/elements/element.hpp"
#include "common/mesh/mesh.hpp"
#include "common/scene/scene_words.hpp"
#include "tests/unit/common/mesh/sample_meshes.hpp"

namespace cbr::test {

inline constexpr std::array<ElementType, 8> volume_types = {
    ElementType::tet4,    ElementType::tet10, ElementType::pyramid5, ElementType::wedge6,
    ElementType::wedge15, ElementType::hex8,  ElementType::hex20,    ElementType::hex27};

struct ElementKind {
  ElementType type;
  HexFormulation hex = HexFormulation::incompatible;
};

inline void PrintTo(const ElementKind& kind, std::ostream* out) {
  *out << element_word(std::string(name(kind.type)), kind.hex);
}

inline std::vector<ElementKind> element_kinds() {
  std::vector<ElementKind> kinds;
  for (const ElementType type : volume_types) kinds.push_back({type});
  for (const auto hex : {HexFormulation::full, HexFormulation::hourglass, HexFormulation::reduced})
    kinds.push_back({ElementType::hex8, hex});
  return kinds;
}

// Linear elements of one cell, by its corners (hex8 order; 8 is its centre).
inline std::vector<std::vector<int>> cell_elements(ElementType type) {
  switch (type) {
    case ElementType::tet4:
    case ElementType::tet10: {
      // Kuhn's six tetrahedra around the diagonal 0 - 6, which conform to those of the next cell.
      std::vector<std::vector<int>> tets;
      for (const auto& [a, b] :
           std::vector<std::pair<int, int>>{{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}})
        tets.push_back({0, a, b, 6});
      return tets;
    }
    case ElementType::wedge6:
    case ElementType::wedge15:
      return {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}};
    case ElementType::pyramid5: {
      std::vector<std::vector<int>> pyramids;
      for (int side = 1; side <= 6; ++side) {
        const auto& face = side_nodes(ElementType::hex8, side);
        pyramids.push_back({face[3], face[2], face[1], face[0], 8});
      }
      return pyramids;
    }
    default:
      return {{0, 1, 2, 3, 4, 5, 6, 7}};
  }
}

// cells x cells x cells on [0, L_x] x ..., corners moved by `warp`, mid-side nodes between the
// moved corners.
inline Mesh box_mesh(
    ElementType type, const std::array<Index, 3>& cells, const Vector3& L,
    const std::function<Vector3(const Vector3&)>& warp = [](const Vector3& x) { return x; }) {
  std::map<std::array<Index, 3>, Index> corner_numbers;  // by twice the grid coordinates
  // by the corners of which the node is the mean
  std::map<std::vector<Index>, Index> middle_numbers;
  std::vector<Vector3> x;
  std::vector<std::vector<Index>> elements;
  const auto corner = [&](const std::array<Index, 3>& key) {
    const auto [entry, is_new] = corner_numbers.try_emplace(key, static_cast<Index>(x.size()));
    if (is_new) {
      Vector3 place;
      for (std::size_t c = 0; c < 3; ++c)
        place(static_cast<Index>(c)) = L(static_cast<Index>(c)) * static_cast<double>(key[c]) /
                                       static_cast<double>(2 * cells[c]);
      x.push_back(warp(place));
    }
    return entry->second;
  };
  const std::vector<std::array<Index, 3>> offsets = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0},
                                                     {0, 2, 0}, {0, 0, 2}, {2, 0, 2},
                                                     {2, 2, 2}, {0, 2, 2}, {1, 1, 1}};
  const auto parts = cell_elements(type);
  const auto parents = node_corners(type);
  for (Index k = 0; k < cells[2]; ++k)
    for (Index j = 0; j < cells[1]; ++j)
      for (Index i = 0; i < cells[0]; ++i)
        for (const auto& part : parts) {
          std::vector<Index> corners, nodes;
          for (const int c : part) {
            const auto& o = offsets[c];
            corners.push_back(corner({2 * i + o[0], 2 * j + o[1], 2 * k + o[2]}));
          }
          for (const auto& list : parents) {
            std::vector<Index> key;
            for (const int c : list) key.push_back(corners[c]);
            if (key.size() == 1) {
              nodes.push_back(key[0]);
              continue;
            }
            std::sort(key.begin(), key.end());
            const auto [entry, is_new] =
                middle_numbers.try_emplace(key, static_cast<Index>(x.size()));
            if (is_new) {
              Vector3 mean = Vector3::Zero();
              for (const Index node : key) mean += x[node] / static_cast<double>(key.size());
              x.push_back(mean);
            }
            nodes.push_back(entry->second);
          }
          elements.push_back(nodes);
        }
  Mesh mesh;
  mesh.coordinates.resize(static_cast<Index>(x.size()), 3);
  for (std::size_t i = 0; i < x.size(); ++i) {
    mesh.coordinates.row(static_cast<Index>(i)) = x[i].transpose();
    mesh.node_ids.push_back(static_cast<Index>(i) + 1);
  }
  Block block;
  block.name = "solid";
  block.id = 1;
  block.type = type;
  block.connectivity.resize(static_cast<Index>(elements.size()), n_nodes(type));
  for (std::size_t e = 0; e < elements.size(); ++e) {
    for (std::size_t i = 0; i < elements[e].size(); ++i)
      block.connectivity(static_cast<Index>(e), static_cast<Index>(i)) = elements[e][i];
    block.element_ids.push_back(static_cast<Index>(e) + 1);
  }
  mesh.blocks.push_back(block);
  return mesh;
}

inline Points points_of(const Mesh& mesh, const Block& block, Index e) {
  Points X(block.connectivity.cols(), 3);
  for (Index i = 0; i < X.rows(); ++i) X.row(i) = mesh.coordinates.row(block.connectivity(e, i));
  return X;
}

// In [-1, 1]; the same numbers on all platforms.
class Random {
 public:
  explicit Random(std::uint64_t seed = 1) : state_(seed) {}
  double operator()() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) / static_cast<double>(std::uint64_t{1} << 52) - 1;
  }

 private:
  std::uint64_t state_;
};

// A rotation about a general axis.
inline Matrix3 some_rotation() {
  const Vector3 axis = Vector3(0.3, -0.8, 0.52).normalized();
  Matrix3 cross;
  cross << 0, -axis(2), axis(1), axis(2), 0, -axis(0), -axis(1), axis(0), 0;
  const double angle = 0.83;
  return Matrix3::Identity() + std::sin(angle) * cross + (1 - std::cos(angle)) * cross * cross;
}

// The same with sidesets `low` and `high` at z = 0 and z = L_z.
inline Mesh box_with_faces(ElementType type, const std::array<Index, 3>& cells, const Vector3& L,
                           const std::string& low, const std::string& high) {
  Mesh mesh = box_mesh(type, cells, L);
  for (const double z : {0.0, L[2]}) {
    Sideset set{z > 0 ? high : low, static_cast<Index>(mesh.sidesets.size() + 1), {}};
    for (Index e = 0; e < mesh.blocks[0].connectivity.rows(); ++e)
      for (int side = 1; side <= n_sides(mesh.blocks[0].type); ++side) {
        const std::vector<Index> nodes = nodes_of_side(mesh, {0, e, side});
        if (std::all_of(nodes.begin(), nodes.end(),
                        [&](Index node) { return std::abs(mesh.coordinates(node, 2) - z) < 1e-9; }))
          set.sides.push_back({0, e, side});
      }
    mesh.sidesets.push_back(std::move(set));
  }
  return mesh;
}

}  // namespace cbr::test
