// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/surface.hpp"

#include <algorithm>
#include <map>

#include "common/base/error.hpp"
#include "common/mesh/face_weights.hpp"

namespace cbr {
namespace {

bool is_quadratic(FaceKind kind) { return n_nodes(kind) > n_corners(kind); }

// The one kind that holds all faces of a set; a tri3 fits in a quad4, a tri6 in a quad8.
FaceKind common_kind(const Mesh& mesh, const Sideset& sideset) {
  bool first = true;
  FaceKind kind = FaceKind::quad4;
  for (const Side& side : sideset.sides) {
    const Block& block = mesh.blocks[side.block];
    const bool is_face = is_structure(block) && (dimension(block.type) == 3 || side.side <= 2);
    if (!is_face)
      throw InputError(
          "sideset '" + sideset.name + "': element " +
          std::to_string(block.element_ids[side.element]) + " of block '" + block.name + "' is a " +
          std::string(name(block.type)) +
          ": only sides of volume elements make a surface, and faces of shells with a thickness");
    const FaceKind found = dimension(block.type) == 3 ? side_kind(block.type, side.side)
                                                      : static_cast<FaceKind>(n_nodes(block.type));
    const bool fits = is_quadratic(found) == is_quadratic(kind) && found != FaceKind::quad9 &&
                      kind != FaceKind::quad9;
    if (!first && found != kind && !fits)
      throw InputError("sideset '" + sideset.name + "' mixes " + std::string(name(kind)) + " and " +
                       std::string(name(found)) +
                       " faces: only tri3 and quad4, or tri6 and quad8, may share a set: split it");
    kind = first || n_nodes(found) > n_nodes(kind) ? found : kind;
    first = false;
  }
  return kind;
}

// The nodes of a face in a row of more columns: a triangle is a quad whose third side has no length
// and the last corner as its mid-side.
std::vector<Index> widened(std::vector<Index> nodes, std::size_t columns) {
  const bool has_mid_sides = nodes.size() == 6;
  if (nodes.size() == columns) return nodes;
  nodes.insert(nodes.begin() + 3, nodes[2]);
  if (has_mid_sides) nodes.insert(nodes.begin() + 6, nodes[2]);
  return nodes;
}

}  // namespace

Surface extract_surface(const Mesh& mesh, const Sideset& sideset) {
  Surface surface;
  surface.name = sideset.name;
  surface.kind = common_kind(mesh, sideset);
  const Index f = static_cast<Index>(sideset.sides.size());
  surface.faces.resize(f, n_nodes(surface.kind));
  for (Index i = 0; i < f; ++i) {
    const Side& side = sideset.sides[i];
    const auto columns = static_cast<std::size_t>(surface.faces.cols());
    const auto nodes = widened(nodes_of_side(mesh, side), columns);
    for (std::size_t j = 0; j < columns; ++j) surface.faces(i, static_cast<Index>(j)) = nodes[j];
    surface.element.push_back(mesh.blocks[side.block].element_ids[side.element]);
    surface.side.push_back(side.side);
  }
  return surface;
}

std::vector<Index> surface_nodes(const Surface& surface) {
  std::vector<Index> nodes(surface.faces.data(), surface.faces.data() + surface.faces.size());
  sort_uniquely(nodes);
  return nodes;
}

std::vector<Index> nodes_of_face(const Surface& surface, Index face) {
  const auto row = surface.faces.row(face);
  std::vector<Index> nodes(row.begin(), row.end());
  if (surface.kind != FaceKind::quad9 && n_corners(surface.kind) == 4 && row(2) == row(3)) {
    if (surface.kind == FaceKind::quad8) nodes.erase(nodes.begin() + 6);
    nodes.erase(nodes.begin() + 3);
  }
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
  LinearFaces linear;
  linear.faces.resize(surface.n_faces() * static_cast<Index>(all.at(n_nodes(surface.kind)).size()),
                      4);
  for (Index f = 0; f < surface.n_faces(); ++f) {
    const std::vector<Index> nodes = nodes_of_face(surface, f);
    for (const auto& piece : all.at(static_cast<int>(nodes.size()))) {
      const auto row = static_cast<Index>(linear.parent.size());
      for (Index j = 0; j < 4; ++j) linear.faces(row, j) = nodes[piece[j]];
      linear.parent.push_back(f);
    }
  }
  linear.faces.conservativeResize(static_cast<Index>(linear.parent.size()), Eigen::NoChange);
  return linear;
}

}  // namespace cbr
