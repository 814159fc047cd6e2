// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh from a .msh file. Physical volumes become blocks, physical surfaces sidesets,
// physical curves and points nodesets.
#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "common/base/error.hpp"
#include "common/mesh/io/file_mesh.hpp"
#include "common/mesh/io/gmsh_types.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

// All elements of one physical group, or of an entity that is in none.
struct Group {
  int dimension = 0;
  Index tag = 0;  // of the physical group; of the entity when there is none
  bool physical = false;
  std::string name;
  std::vector<const MshElement*> elements;
};

const char* entity_word(int dimension) {
  static const char* words[] = {"point", "curve", "surface", "volume"};
  return words[dimension];
}

// By dimension, physical groups first, then tag.
std::vector<Group> groups_of(const MshFile& msh) {
  std::map<std::tuple<int, bool, Index>, Group> groups;  // (dimension, not physical, tag)
  for (const auto& element : msh.elements) {
    const auto add = [&](bool physical, Index tag) {
      Group& group = groups[{element.dimension, !physical, tag}];
      group.dimension = element.dimension;
      group.tag = tag;
      group.physical = physical;
      group.elements.push_back(&element);
    };
    if (msh.version < 4) {
      add(element.group != 0, element.group != 0 ? element.group : element.entity);
      continue;
    }
    const auto found = msh.groups_of_entity.find({element.dimension, element.entity});
    if (found == msh.groups_of_entity.end() || found->second.empty()) {
      add(false, element.entity);
    } else {
      for (const Index tag : std::set<Index>(found->second.begin(), found->second.end()))
        add(true, tag);
    }
  }
  std::vector<Group> list;
  for (auto& [key, group] : groups) {
    const auto named = msh.group_names.find({group.dimension, group.tag});
    if (group.physical && named != msh.group_names.end()) group.name = named->second;
    if (group.name.empty())
      group.name = std::string(entity_word(group.dimension)) + "_" + std::to_string(group.tag);
    list.push_back(std::move(group));
  }
  return list;
}

using NodeIndex = std::unordered_map<Index, Index>;

// Nodes by ascending id, whatever their order in the file.
NodeIndex load_nodes(const std::string& where, const MshFile& msh, Mesh& mesh) {
  std::vector<std::size_t> order(msh.node_ids.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return msh.node_ids[a] < msh.node_ids[b]; });
  NodeIndex index;
  index.reserve(order.size());
  mesh.coordinates.resize(static_cast<Index>(order.size()), 3);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto row = static_cast<Index>(i);
    for (Index c = 0; c < 3; ++c)
      mesh.coordinates(row, c) = msh.coordinates[3 * order[i] + static_cast<std::size_t>(c)];
    mesh.node_ids.push_back(msh.node_ids[order[i]]);
    if (!index.emplace(msh.node_ids[order[i]], row).second)
      throw InputError(where + ": node " + std::to_string(msh.node_ids[order[i]]) +
                       " is defined twice: node numbers must be unique");
  }
  return index;
}

// The elements of a file, and the numbers of their nodes.
struct Source {
  const MshFile& msh;
  const std::string& where;
  const NodeIndex& index;

  // Nodes of an element in Exodus order, as indices.
  std::vector<Index> nodes_of(const MshElement& element) const {
    const GmshType& type = *find_gmsh_type(element.type);
    std::vector<Index> nodes(type.n_nodes);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Index id =
          msh.element_nodes[element.first +
                            (type.order.empty() ? i : static_cast<std::size_t>(type.order[i]))];
      const auto found = index.find(id);
      if (found == index.end())
        throw InputError(where + ": element " + std::to_string(element.id) + " refers to node " +
                         std::to_string(id) + ", which the file does not define");
      nodes[i] = found->second;
    }
    return nodes;
  }
};

// Volume elements that are in a block already. Format 4 gives an element of two groups one number;
// format 2 repeats it.
struct Taken {
  bool by_nodes = false;
  std::set<std::vector<Index>> nodes;
  std::unordered_set<Index> ids;

  bool insert(const MshElement& element, std::vector<Index> its_nodes) {
    if (!by_nodes) return ids.insert(element.id).second;
    std::sort(its_nodes.begin(), its_nodes.end());
    return nodes.insert(its_nodes).second;
  }
};

// One block per element type of the group, without the elements that are `taken`.
void add_blocks(const Group& group, const Source& source, Taken* taken, Mesh& mesh) {
  std::map<ElementType, std::pair<std::vector<Index>, std::vector<Index>>> by_type;  // ids, nodes
  for (const MshElement* element : group.elements) {
    const auto nodes = source.nodes_of(*element);
    if (taken != nullptr && !taken->insert(*element, nodes)) continue;
    auto& [ids, all] = by_type[*find_gmsh_type(element->type)->type];
    ids.push_back(element->id);
    all.insert(all.end(), nodes.begin(), nodes.end());
  }
  for (auto& [type, lists] : by_type) {
    Block block;
    block.name = by_type.size() == 1 ? group.name : group.name + "_" + std::string(name(type));
    block.id = group.tag;
    block.type = type;
    block.element_ids = lists.first;
    block.connectivity = Eigen::Map<const IndexTable>(
        lists.second.data(), static_cast<Index>(lists.first.size()), n_nodes(type));
    mesh.blocks.push_back(std::move(block));
  }
}

// A physical surface: a sideset when its faces are sides of volumes, else (and for a skin) a block
// of shells.
void add_surface(const Group& group, const Source& source, const SideLookup& lookup, Mesh& mesh) {
  Sideset set{group.name, group.tag, {}};
  std::optional<Index> first_loose;
  std::size_t n_loose = 0;
  const bool skin = group.name.rfind("skin.", 0) == 0;
  std::set<std::tuple<Index, Index, int>> seen;
  for (const MshElement* element : group.elements) {
    if (skin) break;
    auto corners = source.nodes_of(*element);
    corners.resize(n_corners(*find_gmsh_type(element->type)->type));
    const Side side = lookup.find(corners);
    if (side.element < 0) {
      if (++n_loose == 1) first_loose = element->id;
    } else if (seen.insert({side.block, side.element, side.side}).second) {
      set.sides.push_back(side);
    }
  }
  if (skin || n_loose == group.elements.size()) {
    add_blocks(group, source, nullptr, mesh);
  } else if (n_loose > 0) {
    throw InputError(
        source.where + ": physical surface '" + group.name + "': " + std::to_string(n_loose) +
        " of its " + std::to_string(group.elements.size()) +
        " faces are sides of no volume element (the first is element " +
        std::to_string(*first_loose) + "): put shells in a physical surface of their own");
  } else {
    mesh.sidesets.push_back(std::move(set));
  }
}

void add_nodes(const Group& group, const Source& source, Mesh& mesh) {
  std::vector<Index> nodes;
  for (const MshElement* element : group.elements)
    for (const Index node : source.nodes_of(*element)) nodes.push_back(node);
  add_nodeset(mesh, group.name, std::move(nodes), group.tag);
}

// Flags the nodes of all faces in physical groups.
std::vector<bool> face_nodes(const std::vector<Group>& groups, const Source& source) {
  std::vector<bool> flags(source.index.size(), false);
  for (const auto& group : groups)
    if (group.dimension == 2 && group.physical)
      for (const MshElement* element : group.elements)
        for (const Index node : source.nodes_of(*element)) flags[node] = true;
  return flags;
}

}  // namespace

Mesh read_gmsh(const std::filesystem::path& file) {
  const std::string where = file.string();
  const MshFile msh = read_msh(file);
  Mesh mesh;
  const NodeIndex index = load_nodes(where, msh, mesh);
  const Source source{msh, where, index};
  const std::vector<Group> groups = groups_of(msh);
  // An element of several physical volumes goes to the block of the lowest tag: an element has one
  // material.
  const auto n_volumes =
      std::count_if(groups.begin(), groups.end(), [](const Group& g) { return g.dimension == 3; });
  Taken taken{msh.version < 4, {}, {}};
  for (const auto& group : groups)
    if (group.dimension == 3) add_blocks(group, source, n_volumes > 1 ? &taken : nullptr, mesh);
  const bool solid = !mesh.blocks.empty();
  const SideLookup lookup(mesh, face_nodes(groups, source));
  for (const auto& group : groups) {
    // Faces, lines and points in no physical group are only the geometry's; without solids the
    // faces are the mesh.
    if (group.dimension == 2 && group.physical) add_surface(group, source, lookup, mesh);
    if (group.dimension == 2 && !group.physical && !solid) add_blocks(group, source, nullptr, mesh);
    if (group.dimension < 2 && group.physical) add_nodes(group, source, mesh);
  }
  return mesh;
}

}  // namespace cbr
