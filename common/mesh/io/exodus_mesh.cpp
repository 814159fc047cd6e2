// SPDX-License-Identifier: GPL-3.0-or-later
// Reads Exodus II. Names of dimensions and variables: Schoof and Yarberry, EXODUS II: A Finite
// Element Data Model, SAND92-2137.
#include <algorithm>

#include "common/base/error.hpp"
#include "common/files/netcdf_file.hpp"
#include "common/mesh/io/deck_lines.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

// The usual spellings differ after the family's name; the number of nodes decides.
ElementType element_type(const NetcdfReader& file, const std::string& block,
                         const std::string& text, Index n_nodes_found) {
  const std::string upper = in_capitals(text);
  struct Family {
    const char* prefix;
    std::vector<ElementType> types;
  };
  using enum ElementType;
  static const std::vector<Family> families = {
      {"HEX", {hex8, hex20, hex27}},  {"TET", {tet4, tet10}},
      {"WED", {wedge6, wedge15}},     {"PYR", {pyramid5}},
      {"QUA", {quad4, quad8, quad9}}, {"SHE", {tri3, tri6, quad4, quad8, quad9}},
      {"TRI", {tri3, tri6}}};
  for (const auto& family : families)
    if (upper.rfind(family.prefix, 0) == 0)
      for (const auto type : family.types)
        if (n_nodes(type) == n_nodes_found) return type;
  throw InputError(file.where() + ": block '" + block + "': element type '" + text + "' with " +
                   std::to_string(n_nodes_found) +
                   " nodes is not supported: use HEX 8 20 27, TETRA 4 10, WEDGE 6 15, PYRAMID 5, "
                   "SHELL or QUAD 4 8 9, TRI 3 6, and take "
                   "beams, trusses and points out of the mesh");
}

struct SetHeader {
  Index id = 0;
  std::string name;
};

// Ids and names of blocks or sets; an unnamed one is called after its id, as SEACAS's programs do.
std::vector<SetHeader> headers(const NetcdfReader& file, const std::string& dimension,
                               const std::string& prefix, const std::string& word) {
  const Index n = file.dimension(dimension);
  const std::string prop = prefix + "_prop1", names = prefix + "_names";
  std::vector<SetHeader> found(n);
  std::vector<Index> ids;
  std::vector<std::string> texts;
  if (n > 0 && file.has(prop)) ids = file.integers(prop);
  if (n > 0 && file.has(names)) texts = file.strings(names);
  for (std::size_t i = 0; i < found.size(); ++i) {
    found[i].id = i < ids.size() ? ids[i] : static_cast<Index>(i) + 1;
    found[i].name =
        i < texts.size() && !texts[i].empty() ? texts[i] : word + "_" + std::to_string(found[i].id);
  }
  return found;
}

std::vector<Index> id_map(const NetcdfReader& file, const std::string& name, Index n) {
  std::vector<Index> ids;
  if (file.has(name)) {
    ids = file.integers(name);
    if (static_cast<Index>(ids.size()) != n)
      throw InputError(file.where() + ": " + name + ": has " + std::to_string(ids.size()) +
                       " entries for " + std::to_string(n));
    for (const Index id : ids)
      if (id < 1)
        throw InputError(file.where() + ": " + name + ": id " + std::to_string(id) +
                         " found, ids are at least 1: damaged");
  } else {
    for (Index i = 1; i <= n; ++i) ids.push_back(i);
  }
  return ids;
}

void read_nodes(const NetcdfReader& file, Mesh& mesh) {
  const Index n = file.dimension("num_nodes"), dim = file.dimension("num_dim");
  if (n < 1)
    throw InputError(file.where() + ": num_nodes: there are no nodes: not an Exodus II mesh");
  if (dim != 2 && dim != 3)
    throw InputError(file.where() + ": num_dim: 2 or 3 are allowed, not " + std::to_string(dim));
  const bool joint = file.has("coord");
  for (Index c = 0; c < dim; ++c) {
    const std::string name = joint ? "coord" : std::string("coord") + "xyz"[c];
    const auto values = file.reals(name);
    const Index wanted = joint ? dim * n : n;
    if (static_cast<Index>(values.size()) != wanted)
      throw InputError(file.where() + ": " + name + ": has " + std::to_string(values.size()) +
                       " values, not " + std::to_string(wanted));
    if (c == 0) mesh.coordinates = Points::Zero(n, 3);
    for (Index i = 0; i < n; ++i) mesh.coordinates(i, c) = values[joint ? c * n + i : i];
  }
  mesh.node_ids = id_map(file, "node_num_map", n);
}

void read_blocks(const NetcdfReader& file, Mesh& mesh) {
  const auto blocks = headers(file, "num_el_blk", "eb", "block");
  const Index n_elements = file.dimension("num_elem");
  const auto ids = id_map(file, "elem_num_map", n_elements);
  std::size_t next = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const std::string number = std::to_string(b + 1), connect = "connect" + number;
    // A null block has an id, and neither elements nor a type.
    if (!file.has(connect) && file.dimension("num_el_in_blk" + number) == 0) continue;
    const auto shape = file.shape(connect);
    if (shape.size() != 2)
      throw InputError(file.where() + ": " + connect + ": should have two dimensions");
    Block block;
    block.name = blocks[b].name;
    block.id = blocks[b].id;
    block.type = element_type(file, block.name, file.text(connect, "elem_type"), shape[1]);
    auto nodes = file.integers(connect);
    for (auto& node : nodes) {
      if (node < 1 || node > mesh.coordinates.rows())
        throw InputError(file.where() + ": " + connect + ": node number " + std::to_string(node) +
                         " found, allowed are 1 to " + std::to_string(mesh.coordinates.rows()));
      --node;
    }
    block.connectivity = Eigen::Map<const IndexTable>(nodes.data(), shape[0], shape[1]);
    if (next + static_cast<std::size_t>(shape[0]) > ids.size())
      throw InputError(file.where() + ": " + connect +
                       ": the blocks hold more elements than num_elem, " +
                       std::to_string(n_elements));
    const auto first = ids.begin() + static_cast<std::ptrdiff_t>(next);
    block.element_ids.assign(first, first + shape[0]);
    next += static_cast<std::size_t>(shape[0]);
    mesh.blocks.push_back(std::move(block));
  }
  if (next != ids.size())
    throw InputError(file.where() + ": num_elem: announces " + std::to_string(n_elements) +
                     " elements, the blocks hold " + std::to_string(next));
}

void read_sidesets(const NetcdfReader& file, Mesh& mesh) {
  std::vector<Side> elements;  // by the number in the file
  for (Index b = 0; b < static_cast<Index>(mesh.blocks.size()); ++b)
    for (Index e = 0; e < mesh.blocks[b].connectivity.rows(); ++e) elements.push_back({b, e, 0});
  const auto sets = headers(file, "num_side_sets", "ss", "surface");
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const std::string element_name = "elem_ss" + std::to_string(s + 1),
                      side_name = "side_ss" + std::to_string(s + 1);
    Sideset set{sets[s].name, sets[s].id, {}};
    if (file.has(element_name)) {
      const auto element = file.integers(element_name), side = file.integers(side_name);
      if (element.size() != side.size())
        throw InputError(file.where() + ": " + side_name + ": has " + std::to_string(side.size()) +
                         " entries, " + element_name + " " + std::to_string(element.size()));
      for (std::size_t i = 0; i < element.size(); ++i) {
        if (element[i] < 1 || element[i] > static_cast<Index>(elements.size()))
          throw InputError(file.where() + ": " + element_name + ": element number " +
                           std::to_string(element[i]) + " found, allowed are 1 to " +
                           std::to_string(elements.size()));
        Side found = elements[element[i] - 1];
        // check_mesh refuses wrong sides
        found.side = static_cast<int>(std::clamp<Index>(side[i], -1, 1000));
        set.sides.push_back(found);
      }
    } else if (file.dimension("num_side_ss" + std::to_string(s + 1)) > 0) {
      throw InputError(file.where() + ": " + element_name + ": there is no such variable: damaged");
    }
    mesh.sidesets.push_back(std::move(set));
  }
}

void read_nodesets(const NetcdfReader& file, Mesh& mesh) {
  const auto sets = headers(file, "num_node_sets", "ns", "nodelist");
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const std::string name = "node_ns" + std::to_string(s + 1);
    Nodeset set{sets[s].name, sets[s].id, {}};
    if (file.has(name)) {
      set.nodes = file.integers(name);
    } else if (file.dimension("num_nod_ns" + std::to_string(s + 1)) > 0) {
      throw InputError(file.where() + ": " + name + ": there is no such variable: damaged");
    }
    for (auto& node : set.nodes) {
      if (node < 1 || node > mesh.coordinates.rows())
        throw InputError(file.where() + ": " + name + ": node number " + std::to_string(node) +
                         " found, allowed are 1 to " + std::to_string(mesh.coordinates.rows()));
      --node;
    }
    sort_uniquely(set.nodes);
    mesh.nodesets.push_back(std::move(set));
  }
}

}  // namespace

Mesh read_exodus(const std::filesystem::path& file) {
  const NetcdfReader reader(file);
  Mesh mesh;
  read_nodes(reader, mesh);
  read_blocks(reader, mesh);
  read_sidesets(reader, mesh);
  read_nodesets(reader, mesh);
  return mesh;
}

}  // namespace cbr
