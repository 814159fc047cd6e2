// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/mesh.hpp"

#include <algorithm>
#include <set>
#include <unordered_set>

#include "common/base/error.hpp"
#include "common/base/name_text.hpp"

namespace cbr {
namespace {

template <class Sets>
Index find_by_name(const Sets& sets, const std::string& name) {
  for (std::size_t i = 0; i < sets.size(); ++i)
    if (sets[i].name == name) return static_cast<Index>(i);
  return -1;
}

// A bare number stands for the unnamed set of that id.
template <class Sets>
Index find_set(const Sets& sets, const std::string& name, const std::string& prefix) {
  const Index found = find_by_name(sets, name);
  const bool number = !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
  return found >= 0 || !number ? found : find_by_name(sets, prefix + name);
}

template <class Sets>
std::vector<std::string> names_of(const Sets& sets) {
  std::vector<std::string> names;
  for (const auto& set : sets) names.push_back(set.name);
  return names;
}

template <class Sets>
void check_names(const Sets& sets, const std::string& where, const std::string& what) {
  std::set<std::string> seen;
  for (const auto& set : sets)
    if (const std::string problem = name_problem(set.name); !problem.empty())
      throw InputError(where + ": the name of " + what + " " + std::to_string(set.id) + ", '" +
                       printable_name(set.name) + "', " + problem + ": rename it");
  for (const auto& set : sets)
    if (!seen.insert(set.name).second)
      throw InputError(where + ": two " + what + "s are named '" + set.name +
                       "': names must be unique, rename one of them");
}

void check_nodes(const Mesh& mesh, const std::string& where) {
  const Index n = mesh.coordinates.rows();
  std::unordered_set<Index> ids;
  ids.reserve(n);
  for (Index i = 0; i < n; ++i) {
    const Index id = mesh.node_ids[i];
    if (!ids.insert(id).second)
      throw InputError(where + ": node id " + std::to_string(id) +
                       " is used twice: ids must be unique");
    if (!mesh.coordinates.row(i).allFinite())
      throw InputError(where + ": a coordinate of node " + std::to_string(id) +
                       " is not a finite number");
  }
}

void check_blocks(const Mesh& mesh, const std::string& where) {
  std::unordered_set<Index> ids;
  for (const auto& block : mesh.blocks) {
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const Index id = block.element_ids[e];
      if (!ids.insert(id).second)
        throw InputError(where + ": block '" + block.name + "': element id " + std::to_string(id) +
                         " is used twice: ids must be unique");
      for (Index i = 0; i < block.connectivity.cols(); ++i)
        if (block.connectivity(e, i) < 0 || block.connectivity(e, i) >= mesh.coordinates.rows())
          throw InputError(where + ": block '" + block.name + "': element " + std::to_string(id) +
                           " refers to node number " +
                           std::to_string(block.connectivity(e, i) + 1) + ", but the mesh has " +
                           std::to_string(mesh.coordinates.rows()) + " nodes");
    }
  }
}

bool is_side(const Mesh& mesh, const Side& side) {
  if (side.block < 0 || side.block >= static_cast<Index>(mesh.blocks.size())) return false;
  const Block& block = mesh.blocks[side.block];
  const int allowed = dimension(block.type) == 3 ? n_sides(block.type) : 2 + n_corners(block.type);
  return side.element >= 0 && side.element < block.connectivity.rows() && side.side >= 1 &&
         side.side <= allowed;
}

}  // namespace

bool is_structure(const Block& block) { return dimension(block.type) == 3 || block.thickness > 0; }

Index find_block(const Mesh& mesh, const std::string& name) {
  return find_set(mesh.blocks, name, "block_");
}
Index find_sideset(const Mesh& mesh, const std::string& name) {
  return find_set(mesh.sidesets, name, "surface_");
}
Index find_nodeset(const Mesh& mesh, const std::string& name) {
  return find_set(mesh.nodesets, name, "nodelist_");
}

std::string set_names(const Mesh& mesh) {
  std::vector<std::string> parts;
  if (!mesh.sidesets.empty()) parts.push_back(join(names_of(mesh.sidesets)) + " (sidesets)");
  if (!mesh.nodesets.empty()) parts.push_back(join(names_of(mesh.nodesets)) + " (nodesets)");
  return parts.empty() ? "none; in gmsh a face gets its name by Physical Surface(\"NAME\") = {TAG}"
                       : join(parts, "; ");
}

std::vector<Index> nodes_of_side(const Mesh& mesh, const Side& side) {
  if (!is_side(mesh, side))
    throw InputError("side " + std::to_string(side.side) +
                     " is not a side of any element of the mesh");
  const Block& block = mesh.blocks[side.block];
  std::vector<Index> nodes;
  const auto add = [&](int local) { nodes.push_back(block.connectivity(side.element, local)); };
  if (dimension(block.type) == 3) {
    for (const int local : side_nodes(block.type, side.side)) add(local);
  } else if (side.side == 1) {
    for (int i = 0; i < n_nodes(block.type); ++i) add(i);
  } else if (side.side == 2) {
    const auto& order = mirrored_order(block.type);
    for (int i = 0; i < n_nodes(block.type); ++i) add(order[i]);
  } else {
    const int corners = n_corners(block.type), edge = side.side - 3;
    add(edge);
    add((edge + 1) % corners);
    if (n_nodes(block.type) > corners) add(corners + edge);
  }
  return nodes;
}

std::vector<Index> set_nodes(const Mesh& mesh, const std::string& name) {
  std::vector<Index> nodes;
  const Index s = find_sideset(mesh, name);
  const Index n = find_nodeset(mesh, name);
  if (s < 0 && n < 0) {
    std::vector<std::string> names = names_of(mesh.sidesets);
    const auto others = names_of(mesh.nodesets);
    names.insert(names.end(), others.begin(), others.end());
    throw InputError("the mesh has no sideset or nodeset '" + name + "'" +
                     nearest_name(name, names) + " (available: " + set_names(mesh) + ")");
  }
  // A name that both kinds share means the sideset: its nodes are the ones of the faces, which
  // contact and loads need.
  if (s >= 0) {
    for (const Side& side : mesh.sidesets[s].sides)
      for (const Index node : nodes_of_side(mesh, side)) nodes.push_back(node);
  } else {
    nodes = mesh.nodesets[n].nodes;
  }
  sort_uniquely(nodes);
  return nodes;
}

void check_mesh(const Mesh& mesh, const std::string& where) {
  check_nodes(mesh, where);
  check_blocks(mesh, where);
  check_names(mesh.blocks, where, "block");
  check_names(mesh.sidesets, where, "sideset");
  check_names(mesh.nodesets, where, "nodeset");
  for (const auto& set : mesh.sidesets)
    for (const Side& side : set.sides)
      if (!is_side(mesh, side))
        throw InputError(where + ": sideset '" + set.name + "': side " + std::to_string(side.side) +
                         " of element number " + std::to_string(side.element + 1) +
                         " does not exist");
  for (const auto& set : mesh.nodesets)
    for (const Index node : set.nodes)
      if (node < 0 || node >= mesh.coordinates.rows())
        throw InputError(where + ": nodeset '" + set.name + "' refers to node number " +
                         std::to_string(node + 1) + ", but the mesh has " +
                         std::to_string(mesh.coordinates.rows()) + " nodes");
}

}  // namespace cbr
