// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/hinged_shells.hpp"

#include <map>
#include <vector>

#include "common/fem/connected_parts.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

constexpr double on_a_line = 1e-6;  // of the size of the nodes' set

// True if displacements of these places determine all six rigid motions.
bool hold(const Points& all) {
  Points x = all.rowwise() - all.colwise().mean();
  const double size = x.rowwise().norm().maxCoeff();
  return size > 0 && PivotedQr(rigid_modes(x / size, Vector3::Zero()), on_a_line).rank() == 6;
}

}  // namespace

std::string hinged_shells(const Mesh& mesh, const FiniteElementModel& model) {
  if (model.n_rotations == 0) return {};
  Mesh shells;  // alone
  std::vector<char> is_of_solid(mesh.node_ids.size(), 0);
  for (const Block& block : mesh.blocks) {
    if (!is_structure(block)) continue;
    if (dimension(block.type) != 3) {
      shells.blocks.push_back(block);
      continue;
    }
    for (const Index node : block.connectivity.reshaped())
      is_of_solid[static_cast<std::size_t>(node)] = 1;
  }
  shells.coordinates = mesh.coordinates;
  shells.node_ids = mesh.node_ids;
  FiniteElementModel alone;
  number_nodes(shells, alone);
  const std::vector<Index> part = connected_parts(shells, alone);
  std::map<Index, std::vector<Index>> shared;  // of each part, mesh nodes
  for (Index i = 0; i < alone.n_translations(); ++i) {
    const Index node = alone.nodes[static_cast<std::size_t>(i)];
    if (is_of_solid[static_cast<std::size_t>(node)] != 0)
      shared[part[static_cast<std::size_t>(i)]].push_back(node);
  }
  for (const auto& [number, nodes] : shared) {
    if (hold(mesh.coordinates(nodes, Eigen::all))) continue;
    std::string name;
    for (const Block& block : shells.blocks)
      for (const Index node : block.connectivity.reshaped())
        if (name.empty() && node == nodes.front()) name = block.name;
    return "shells of block '" + name + "' share " + std::to_string(nodes.size()) +
           " nodes with solids, all on one line (first node id " +
           std::to_string(mesh.node_ids[static_cast<std::size_t>(nodes.front())]) +
           "): they turn about it as on a hinge, as solids have no rotations; to hold them, let "
           "them go on along a face of the solids, or hold their rotations "
           "(boundary.rotations)";
  }
  return {};
}

}  // namespace cbr
