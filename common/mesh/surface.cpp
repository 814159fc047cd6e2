// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/surface.hpp"

#include <algorithm>
#include <map>

#include "common/base/error.hpp"

namespace cbr {
namespace {

bool is_quadratic(FaceKind kind) { return n_nodes(kind) > n_corners(kind); }

// The one kind that holds all faces of a set; a tri3 fits in a quad4.
FaceKind common_kind(const Mesh& mesh, const Sideset& sideset) {
  bool first = true;
  FaceKind kind = FaceKind::quad4;
  for (const Side& side : sideset.sides) {
    const Block& block = mesh.blocks[static_cast<std::size_t>(side.block)];
    const bool is_face = is_structure(block) && (dimension(block.type) == 3 || side.side <= 2);
    if (!is_face)
      throw InputError(
          "sideset '" + sideset.name + "': element " +
          std::to_string(block.element_ids[static_cast<std::size_t>(side.element)]) +
          " of block '" + block.name + "' is a " + std::string(name(block.type)) +
          ": only sides of volume elements make a surface, and faces of shells with a thickness");
    const FaceKind found = dimension(block.type) == 3 ? side_kind(block.type, side.side)
                                                      : static_cast<FaceKind>(n_nodes(block.type));
    if (!first && found != kind && (is_quadratic(found) || is_quadratic(kind)))
      throw InputError("sideset '" + sideset.name + "' mixes " + std::string(name(kind)) + " and " +
                       std::string(name(found)) +
                       " faces: only tri3 and quad4 may share a set, split it");
    kind = first || n_nodes(found) > n_nodes(kind) ? found : kind;
    first = false;
  }
  return kind;
}

}  // namespace

Surface extract_surface(const Mesh& mesh, const Sideset& sideset) {
  Surface surface;
  surface.name = sideset.name;
  surface.kind = common_kind(mesh, sideset);
  const Index f = static_cast<Index>(sideset.sides.size());
  surface.faces.resize(f, n_nodes(surface.kind));
  for (Index i = 0; i < f; ++i) {
    const Side& side = sideset.sides[static_cast<std::size_t>(i)];
    const auto nodes = nodes_of_side(mesh, side);
    for (Index j = 0; j < surface.faces.cols(); ++j)
      surface.faces(i, j) = nodes[std::min(static_cast<std::size_t>(j), nodes.size() - 1)];
    surface.element.push_back(mesh.blocks[static_cast<std::size_t>(side.block)]
                                  .element_ids[static_cast<std::size_t>(side.element)]);
    surface.side.push_back(side.side);
  }
  return surface;
}

std::vector<Index> surface_nodes(const Surface& surface) {
  std::vector<Index> nodes(surface.faces.data(), surface.faces.data() + surface.faces.size());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

LinearFaces linear_faces(const Surface& surface) {
  // By the number of nodes: local nodes of the pieces; all keep the face's sense of rotation.
  static const std::map<int, std::vector<std::vector<int>>> all = {
      {3, {{0, 1, 2, 2}}},
      {4, {{0, 1, 2, 3}}},
      {6, {{0, 3, 5, 5}, {1, 4, 3, 3}, {2, 5, 4, 4}, {3, 4, 5, 5}}},
      {8, {{0, 4, 7, 7}, {1, 5, 4, 4}, {2, 6, 5, 5}, {3, 7, 6, 6}, {4, 5, 6, 7}}},
      {9, {{0, 4, 8, 7}, {4, 1, 5, 8}, {8, 5, 2, 6}, {7, 8, 6, 3}}}};
  const auto& pieces = all.at(n_nodes(surface.kind));
  LinearFaces linear;
  linear.faces.resize(surface.n_faces() * static_cast<Index>(pieces.size()), 4);
  for (Index f = 0; f < surface.n_faces(); ++f)
    for (const auto& piece : pieces) {
      const auto row = static_cast<Index>(linear.parent.size());
      for (Index j = 0; j < 4; ++j)
        linear.faces(row, j) = surface.faces(f, piece[static_cast<std::size_t>(j)]);
      linear.parent.push_back(f);
    }
  return linear;
}

}  // namespace cbr
