// SPDX-License-Identifier: GPL-3.0-or-later
#include "skinner/placed_mesh.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace cbr {
namespace {

// The smallest m 10^k that frees all ids, with 10^k above the part's highest id, so that the old
// number stays readable in the new.
Index free_offset(const std::set<Index>& used, const std::vector<Index>& ids) {
  const auto taken = [&](Index offset) {
    return std::any_of(ids.begin(), ids.end(),
                       [&](Index id) { return used.count(id + offset) > 0; });
  };
  if (ids.empty() || !taken(0)) return 0;
  Index step = 10;
  while (step <= *std::max_element(ids.begin(), ids.end())) step *= 10;
  Index offset = step;
  while (taken(offset)) offset += step;
  return offset;
}

void mirror(Mesh& mesh) {
  for (auto& set : mesh.sidesets)
    for (auto& side : set.sides) {
      const ElementType type = mesh.blocks[static_cast<std::size_t>(side.block)].type;
      // Of a shell's sides the two faces stay: what was its front is its front.
      if (dimension(type) == 3) side.side = mirrored_side(type, side.side);
    }
  for (auto& block : mesh.blocks) {
    const auto& order = mirrored_order(block.type);
    const IndexTable old = block.connectivity;
    for (std::size_t i = 0; i < order.size(); ++i)
      block.connectivity.col(static_cast<Index>(i)) = old.col(order[i]);
  }
}

}  // namespace

Mesh place(Mesh mesh, const Instance& instance) {
  const Matrix3 T = instance.transformation();
  // X = X_component T^T + position   (n x 3, a point a row)
  mesh.coordinates =
      ((mesh.coordinates * T.transpose()).rowwise() + instance.position.transpose()).eval();
  if (T.determinant() < 0) mirror(mesh);
  return mesh;
}

Mesh keep_nodes(const Mesh& mesh, const std::vector<Index>& nodes) {
  Mesh kept;
  kept.coordinates.resize(static_cast<Index>(nodes.size()), 3);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    kept.coordinates.row(static_cast<Index>(i)) = mesh.coordinates.row(nodes[i]);
    kept.node_ids.push_back(mesh.node_ids[static_cast<std::size_t>(nodes[i])]);
  }
  for (const auto& set : mesh.nodesets) {
    Nodeset part{set.name, set.id, {}};
    for (const Index node : set.nodes) {
      const auto at = std::lower_bound(nodes.begin(), nodes.end(), node);
      if (at != nodes.end() && *at == node) part.nodes.push_back(at - nodes.begin());
    }
    if (!part.nodes.empty()) kept.nodesets.push_back(std::move(part));
  }
  return kept;
}

SystemMesh::Offsets SystemMesh::add(const Mesh& part, const std::string& name) {
  first_node_ = mesh_.coordinates.rows();
  std::vector<Index> elements;
  for (const auto& block : part.blocks)
    if (dimension(block.type) == 3)
      elements.insert(elements.end(), block.element_ids.begin(), block.element_ids.end());
  const Offsets offsets{free_offset(node_ids_, part.node_ids), free_offset(element_ids_, elements)};

  mesh_.coordinates.conservativeResize(first_node_ + part.coordinates.rows(), 3);
  mesh_.coordinates.bottomRows(part.coordinates.rows()) = part.coordinates;
  for (const Index id : part.node_ids) {
    mesh_.node_ids.push_back(id + offsets.nodes);
    node_ids_.insert(id + offsets.nodes);
  }

  std::vector<Index> block_of_part(part.blocks.size(), -1);
  for (std::size_t b = 0; b < part.blocks.size(); ++b) {
    if (dimension(part.blocks[b].type) != 3) continue;
    Block block = part.blocks[b];
    block.name = name + "." + block.name;
    block.id = static_cast<Index>(mesh_.blocks.size()) + 1;
    block.connectivity.array() += first_node_;
    for (auto& id : block.element_ids) element_ids_.insert(id += offsets.elements);
    block_of_part[b] = static_cast<Index>(mesh_.blocks.size());
    mesh_.blocks.push_back(std::move(block));
  }
  for (const auto& set : part.sidesets) {
    Sideset moved{name + "." + set.name, static_cast<Index>(mesh_.sidesets.size()) + 1, {}};
    for (const Side& side : set.sides) {
      const Index block = block_of_part[static_cast<std::size_t>(side.block)];
      if (block >= 0) moved.sides.push_back({block, side.element, side.side});
    }
    if (!moved.sides.empty()) mesh_.sidesets.push_back(std::move(moved));
  }
  for (const auto& set : part.nodesets) {
    Nodeset moved{name + "." + set.name, static_cast<Index>(mesh_.nodesets.size()) + 1, set.nodes};
    for (auto& node : moved.nodes) node += first_node_;
    mesh_.nodesets.push_back(std::move(moved));
  }
  return offsets;
}

}  // namespace cbr
