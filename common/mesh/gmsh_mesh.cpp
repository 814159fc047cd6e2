// SPDX-License-Identifier: GPL-3.0-or-later
// .msh files through libgmsh (the only code that includes gmsh.h). Physical volumes become blocks, physical surfaces sidesets,
// physical curves and points nodesets.
#include <gmsh.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "common/error.hpp"
#include "common/mesh/gmsh_types.hpp"
#include "common/mesh/mesh_formats.hpp"
#include "common/mesh/msh_file.hpp"

namespace cbr {
namespace {

// libgmsh for the length of one read: no configuration files, no arguments, no output; errors by exception or in the log.
class GmshSession {
 public:
  GmshSession() {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.AbortOnError", 2);
    gmsh::logger::start();
    gmsh::model::add("mesh");
  }
  ~GmshSession() {
    try {
      gmsh::logger::stop();
      gmsh::finalize();
    } catch (...) {  // nothing is left that could use it
    }
  }
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;

  // The first error in the log, or "".
  static std::string error() {
    std::vector<std::string> log;
    gmsh::logger::get(log);
    for (const auto& line : log)
      if (line.rfind("Error", 0) == 0) return line;
    return "";
  }
};

struct RawElement {
  Index id = 0;
  int gmsh_type = 0;
  int entity = 0;
  const std::size_t* nodes = nullptr;  // gmsh's tags in gmsh's order
};

// All elements of one physical group, or of an entity that is in none.
struct Group {
  int dimension = 0;
  Index tag = 0;  // of the physical group; of the entity when there is none
  bool physical = false;
  std::string name;
  std::vector<RawElement> elements;
};

struct Model {
  std::vector<std::vector<std::size_t>> storage;  // owns the elements' nodes
  std::vector<Group> groups;                      // by dimension, physical first, then tag
  Index n_elements = 0;
};

const char* entity_word(int dimension) {
  static const char* words[] = {"point", "curve", "surface", "volume"};
  return words[dimension];
}

[[noreturn]] void refuse_type(const std::string& where, int type, int dimension, int tag) {
  std::string name;
  int d = 0, order = 0, n = 0, corners = 0;
  std::vector<double> local;
  gmsh::model::mesh::getElementProperties(type, name, d, order, n, local, corners);
  throw InputError(where + ": element type '" + name + "' of " + entity_word(dimension) + " " + std::to_string(tag) +
                   " is not supported: mesh with " + supported_gmsh_types());
}

Model load_groups(const std::string& where, const MshFile& msh) {
  Model model;
  std::map<std::tuple<int, bool, Index>, Group> groups;  // (dimension, not physical, tag)
  gmsh::vectorpair entities;
  gmsh::model::getEntities(entities);
  for (const auto& [dimension, entity] : entities) {
    std::vector<int> types, physical;
    std::vector<std::vector<std::size_t>> ids, nodes;
    gmsh::model::mesh::getElements(types, ids, nodes, dimension, entity);
    gmsh::model::getPhysicalGroupsForEntity(dimension, entity, physical);
    std::sort(physical.begin(), physical.end());
    for (std::size_t t = 0; t < types.size(); ++t) {
      if (ids[t].empty()) continue;
      model.n_elements += static_cast<Index>(ids[t].size());
      const GmshType* known = find_gmsh_type(types[t]);
      if (known == nullptr) refuse_type(where, types[t], dimension, entity);
      model.storage.push_back(std::move(nodes[t]));
      for (std::size_t e = 0; e < ids[t].size(); ++e) {
        const auto id = static_cast<Index>(ids[t][e]);
        std::vector<int> tags = physical;
        if (msh.version < 4) {
          const auto group = msh.physical.find(id);
          tags.clear();
          if (group != msh.physical.end() && group->second != 0) tags = {static_cast<int>(std::abs(group->second))};
        }
        const RawElement element{id, types[t], entity, model.storage.back().data() + e * static_cast<std::size_t>(known->n_nodes)};
        const auto add = [&](bool is_physical, Index tag) {
          Group& group = groups[{dimension, !is_physical, tag}];
          group.dimension = dimension, group.tag = tag, group.physical = is_physical;
          group.elements.push_back(element);
        };
        for (const int tag : tags) add(true, std::abs(tag));
        if (tags.empty()) add(false, entity);
      }
    }
  }
  for (auto& [key, group] : groups) {
    if (group.physical) gmsh::model::getPhysicalName(group.dimension, static_cast<int>(group.tag), group.name);
    if (group.name.empty()) group.name = std::string(entity_word(group.dimension)) + "_" + std::to_string(group.tag);
    model.groups.push_back(std::move(group));
  }
  return model;
}

using NodeIndex = std::unordered_map<std::size_t, Index>;

NodeIndex load_nodes(const std::string& where, Mesh& mesh) {
  std::vector<std::size_t> tags;
  std::vector<double> coordinates, parametric;
  gmsh::model::mesh::getNodes(tags, coordinates, parametric);
  std::vector<std::size_t> order(tags.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return tags[a] < tags[b]; });
  NodeIndex index;
  mesh.coordinates.resize(static_cast<Index>(tags.size()), 3);
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (Index c = 0; c < 3; ++c)
      mesh.coordinates(static_cast<Index>(i), c) = coordinates[3 * order[i] + static_cast<std::size_t>(c)];
    mesh.node_ids.push_back(static_cast<Index>(tags[order[i]]));
    if (!index.emplace(tags[order[i]], static_cast<Index>(i)).second)
      throw InputError(where + ": node " + std::to_string(tags[order[i]]) + " is defined twice: node numbers must be unique");
  }
  return index;
}

// Nodes of an element in Exodus order, as indices.
std::vector<Index> nodes_of(const RawElement& element, const NodeIndex& index, const std::string& where) {
  const GmshType& type = *find_gmsh_type(element.gmsh_type);
  std::vector<Index> nodes(static_cast<std::size_t>(type.n_nodes));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::size_t tag = element.nodes[type.order.empty() ? i : static_cast<std::size_t>(type.order[i])];
    const auto found = index.find(tag);
    if (found == index.end())
      throw InputError(where + ": element " + std::to_string(element.id) + " refers to node " + std::to_string(tag) +
                       ", which the file does not define");
    nodes[i] = found->second;
  }
  return nodes;
}

// Volume elements that are in a block already. Format 4 gives an element of two groups one number; format 2 repeats it.
struct Taken {
  bool by_nodes = false;
  std::set<std::vector<Index>> nodes;
  std::unordered_set<Index> ids;

  bool insert(const RawElement& element, std::vector<Index> its_nodes) {
    if (!by_nodes) return ids.insert(element.id).second;
    std::sort(its_nodes.begin(), its_nodes.end());
    return nodes.insert(its_nodes).second;
  }
};

// One block per element type of the group, without the elements that are `taken`.
void add_blocks(const Group& group, const NodeIndex& index, const std::string& where, Taken* taken, Mesh& mesh) {
  std::map<ElementType, std::pair<std::vector<Index>, std::vector<Index>>> by_type;  // ids, nodes
  for (const auto& element : group.elements) {
    const auto nodes = nodes_of(element, index, where);
    if (taken != nullptr && !taken->insert(element, nodes)) continue;
    auto& [ids, all] = by_type[*find_gmsh_type(element.gmsh_type)->type];
    ids.push_back(element.id);
    all.insert(all.end(), nodes.begin(), nodes.end());
  }
  for (auto& [type, lists] : by_type) {
    Block block;
    block.name = by_type.size() == 1 ? group.name : group.name + "_" + std::string(name(type));
    block.id = group.tag;
    block.type = type;
    block.element_ids = lists.first;
    block.connectivity = Eigen::Map<const IndexTable>(lists.second.data(), static_cast<Index>(lists.first.size()), n_nodes(type));
    mesh.blocks.push_back(std::move(block));
  }
}

// A physical surface: a sideset when its faces are sides of volumes, else (and for a skin) a block of shells.
void add_surface(const Group& group, const NodeIndex& index, const SideLookup& lookup, const std::string& where, Mesh& mesh) {
  Sideset set{group.name, group.tag, {}};
  std::optional<Index> first_loose;
  std::size_t n_loose = 0;
  const bool skin = group.name.rfind("skin.", 0) == 0;
  std::set<std::tuple<Index, Index, int>> seen;
  for (const auto& element : group.elements) {
    if (skin) break;
    auto corners = nodes_of(element, index, where);
    corners.resize(static_cast<std::size_t>(n_corners(*find_gmsh_type(element.gmsh_type)->type)));
    const Side side = lookup.find(corners);
    if (side.element < 0) {
      if (++n_loose == 1) first_loose = element.id;
    } else if (seen.insert({side.block, side.element, side.side}).second) {
      set.sides.push_back(side);
    }
  }
  if (skin || n_loose == group.elements.size()) {
    add_blocks(group, index, where, nullptr, mesh);
  } else if (n_loose > 0) {
    throw InputError(where + ": physical surface '" + group.name + "': " + std::to_string(n_loose) + " of its " +
                     std::to_string(group.elements.size()) + " faces are sides of no volume element (the first is element " +
                     std::to_string(*first_loose) + "): put shells in a physical surface of their own");
  } else {
    mesh.sidesets.push_back(std::move(set));
  }
}

void add_nodes(const Group& group, const NodeIndex& index, const std::string& where, Mesh& mesh) {
  Index n = find_nodeset(mesh, group.name);
  if (n < 0) n = static_cast<Index>(mesh.nodesets.size()), mesh.nodesets.push_back({group.name, group.tag, {}});
  auto& nodes = mesh.nodesets[static_cast<std::size_t>(n)].nodes;
  for (const auto& element : group.elements)
    for (const Index node : nodes_of(element, index, where)) nodes.push_back(node);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

// Flags the nodes of all faces in physical groups.
std::vector<bool> face_nodes(const Model& model, const NodeIndex& index, const std::string& where) {
  std::vector<bool> flags(index.size(), false);
  for (const auto& group : model.groups)
    if (group.dimension == 2 && group.physical)
      for (const auto& element : group.elements)
        for (const Index node : nodes_of(element, index, where)) flags[static_cast<std::size_t>(node)] = true;
  return flags;
}

Mesh to_mesh(const std::string& where, const MshFile& msh) {
  Mesh mesh;
  const NodeIndex index = load_nodes(where, mesh);
  const Model model = load_groups(where, msh);
  if (model.n_elements != msh.n_elements)
    throw InputError(where + ": announces " + std::to_string(msh.n_elements) + " elements and holds " +
                     std::to_string(model.n_elements) + ": damaged, or first and second order elements in one entity");
  // An element of several physical volumes goes to the block of the lowest tag: an element has one material.
  const auto n_volumes = std::count_if(model.groups.begin(), model.groups.end(), [](const Group& g) { return g.dimension == 3; });
  Taken taken{msh.version < 4, {}, {}};
  for (const auto& group : model.groups)
    if (group.dimension == 3) add_blocks(group, index, where, n_volumes > 1 ? &taken : nullptr, mesh);
  const bool solid = !mesh.blocks.empty();
  const SideLookup lookup(mesh, face_nodes(model, index, where));
  for (const auto& group : model.groups) {
    // Faces, lines and points in no physical group are only the geometry's; without solids the faces are the mesh.
    if (group.dimension == 2 && group.physical) add_surface(group, index, lookup, where, mesh);
    if (group.dimension == 2 && !group.physical && !solid) add_blocks(group, index, where, nullptr, mesh);
    if (group.dimension < 2 && group.physical) add_nodes(group, index, where, mesh);
  }
  return mesh;
}

}  // namespace

Mesh read_gmsh(const std::filesystem::path& file) {
  const std::string where = file.string();
  const MshFile msh = inspect_msh(file);
  std::string reason;
  try {
    const GmshSession session;
    gmsh::merge(where);
    reason = GmshSession::error();
    if (reason.empty()) return to_mesh(where, msh);
  } catch (const InputError&) {
    throw;
  } catch (const std::string& text) {
    reason = text;
  } catch (const std::exception& error) {
    reason = error.what();
  } catch (int code) {
    reason = "error " + std::to_string(code);
  }
  throw InputError(where + ": gmsh cannot read it: " + reason);
}

}  // namespace cbr
