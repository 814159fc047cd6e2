// SPDX-License-Identifier: GPL-3.0-or-later
// Writes MSH 4.1 as text. With as many digits as give the same doubles back (libgmsh prints 16).
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>

#include "common/base/error.hpp"
#include "common/mesh/io/gmsh_types.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

struct Row {
  Index id = 0;
  std::vector<Index> nodes;  // node ids, gmsh's order
};

// A geometrical entity of the file: elements that are in the same physical groups.
struct Entity {
  int dimension = 0;
  std::vector<Index> physical;
  // gmsh's; one for all elements, as libgmsh loses elements of mixed order in one entity
  int type = 0;
  std::vector<Row> elements;
};

struct Physical {
  int dimension = 0;
  Index tag = 0;
  std::string name;
};

struct Model {
  std::vector<Physical> physical;
  // by dimension; the tag is the position among those of its dimension, from 1
  std::vector<Entity> entities;
};

class Text {
 public:
  explicit Text(const std::filesystem::path& file) : stream_(file, std::ios::binary) {}
  Text& operator<<(const std::string& text) {
    stream_ << text;
    return *this;
  }
  Text& operator<<(const char* text) {
    stream_ << text;
    return *this;
  }
  template <class T>
  Text& operator<<(T value) {  // the shortest text that reads back as the same number
    char buffer[40];
    const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
    stream_.write(buffer, end - buffer);
    return *this;
  }
  bool finish() { return stream_.flush().good(); }

 private:
  std::ofstream stream_;
};

// The set's own id where it is free among the physical groups of this dimension.
Index add_physical(Model& model, int dimension, Index wanted, const std::string& name) {
  Index highest = 0;
  bool taken = wanted < 1;
  for (const auto& p : model.physical) {
    if (p.dimension != dimension) continue;
    highest = std::max(highest, p.tag);
    taken = taken || p.tag == wanted;
  }
  if (name.find_first_of("\"\n\r") != std::string::npos)
    throw InputError(
        "the name '" + name +
        "' has a quote or a line break, which a .msh file cannot hold: rename the set");
  model.physical.push_back({dimension, taken ? highest + 1 : wanted, name});
  return model.physical.back().tag;
}

int face_type(std::size_t n_nodes) {
  switch (n_nodes) {
    case 3:
      return gmsh_type(ElementType::tri3).number;
    case 4:
      return gmsh_type(ElementType::quad4).number;
    case 6:
      return gmsh_type(ElementType::tri6).number;
    case 8:
      return gmsh_type(ElementType::quad8).number;
    default:
      return gmsh_type(ElementType::quad9).number;
  }
}

// A thing that is in several sets needs an entity that carries all of them: entities by combination
// of groups.
template <class Key>
using Membership = std::map<Key, std::vector<Index>>;
using EntityKey = std::pair<std::vector<Index>, int>;  // groups, gmsh's element type

class Builder {
 public:
  explicit Builder(const Mesh& mesh) : mesh_(mesh) {
    for (const auto& block : mesh.blocks)
      for (const Index id : block.element_ids) next_element_ = std::max(next_element_, id + 1);
  }

  Model build() {
    for (const auto& block : mesh_.blocks) add_block(block);
    add_sidesets();
    add_nodesets();
    std::stable_sort(model_.entities.begin(), model_.entities.end(),
                     [](const Entity& a, const Entity& b) { return a.dimension < b.dimension; });
    return std::move(model_);
  }

 private:
  void add_block(const Block& block) {
    const GmshType& type = gmsh_type(block.type);
    Entity entity{dimension(block.type),
                  {add_physical(model_, dimension(block.type), block.id, block.name)},
                  type.number,
                  {}};
    auto& rows = entity.elements;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      Row row{block.element_ids[e], std::vector<Index>(type.n_nodes)};
      for (Index i = 0; i < type.n_nodes; ++i) {
        const Index local = type.order.empty() ? i : type.order[i];
        row.nodes[local] = node_id(block.connectivity(e, i));
      }
      rows.push_back(std::move(row));
    }
    model_.entities.push_back(std::move(entity));
  }

  void add_sidesets() {
    Membership<std::tuple<Index, Index, int>> groups;
    for (const auto& set : mesh_.sidesets) {
      const Index tag = add_physical(model_, 2, set.id, set.name);
      for (const Side& side : set.sides) {
        const Block& block = mesh_.blocks[side.block];
        if (dimension(block.type) != 3)
          throw InputError(
              "sideset '" + set.name +
              "' has sides of shells, which a .msh file cannot hold: write Exodus II instead");
        auto& tags = groups[{side.block, side.element, side.side}];
        if (std::find(tags.begin(), tags.end(), tag) == tags.end()) tags.push_back(tag);
      }
    }
    std::map<EntityKey, Entity> entities;
    for (const auto& [key, tags] : groups) {
      const auto& [b, e, s] = key;
      const Block& block = mesh_.blocks[b];
      Row row{next_element_++, {}};
      for (const int local : side_nodes(block.type, s))
        row.nodes.push_back(node_id(block.connectivity(e, local)));
      const int type = face_type(row.nodes.size());
      entities[{tags, type}].elements.push_back(std::move(row));
    }
    add_entities(2, entities);
  }

  void add_nodesets() {
    Membership<Index> groups;
    for (const auto& set : mesh_.nodesets) {
      const Index tag = add_physical(model_, 0, set.id, set.name);
      for (const Index node : set.nodes) groups[node].push_back(tag);
    }
    std::map<EntityKey, Entity> entities;
    for (const auto& [node, tags] : groups)
      entities[{tags, 15}].elements.push_back({next_element_++, {node_id(node)}});
    add_entities(0, entities);
  }

  void add_entities(int dim, std::map<EntityKey, Entity>& entities) {
    for (auto& [key, entity] : entities) {
      entity.dimension = dim;
      entity.physical = key.first;
      entity.type = key.second;
      model_.entities.push_back(std::move(entity));
    }
  }

  Index node_id(Index node) const { return mesh_.node_ids[node]; }

  const Mesh& mesh_;
  Model model_;
  Index next_element_ = 1;
};

void write_entities(const Mesh& mesh, const Model& model, Text& out) {
  Points box = Points::Zero(2, 3);
  if (mesh.coordinates.rows() > 0) {
    box.row(0) = mesh.coordinates.colwise().minCoeff();
    box.row(1) = mesh.coordinates.colwise().maxCoeff();
  }
  std::array<Index, 4> count{}, tag{};
  for (const auto& entity : model.entities) ++count[entity.dimension];
  out << "$Entities\n" << count[0] << " " << count[1] << " " << count[2] << " " << count[3] << "\n";
  for (const auto& entity : model.entities) {
    const auto d = static_cast<std::size_t>(entity.dimension);
    out << ++tag[d];
    for (Index r = 0; r < (d == 0 ? 1 : 2); ++r)
      for (Index c = 0; c < 3; ++c) out << " " << box(r, c);
    out << " " << entity.physical.size();
    for (const Index p : entity.physical) out << " " << p;
    out << (d == 0 ? "\n" : " 0\n");  // no bounding entities
  }
  out << "$EndEntities\n";
}

void write_nodes(const Mesh& mesh, const Model& model, Text& out) {
  const Index n = mesh.coordinates.rows();
  const auto [low, high] = std::minmax_element(mesh.node_ids.begin(), mesh.node_ids.end());
  // All on the last entity, which has the highest dimension: who the owner is says nothing about
  // the mesh.
  const int dim = model.entities.back().dimension;
  const auto tag = std::count_if(model.entities.begin(), model.entities.end(),
                                 [&](const Entity& e) { return e.dimension == dim; });
  out << "$Nodes\n1 " << n << " " << *low << " " << *high << "\n"
      << dim << " " << static_cast<Index>(tag) << " 0 " << n << "\n";
  for (const Index id : mesh.node_ids) out << id << "\n";
  for (Index i = 0; i < n; ++i)
    out << mesh.coordinates(i, 0) << " " << mesh.coordinates(i, 1) << " " << mesh.coordinates(i, 2)
        << "\n";
  out << "$EndNodes\n";
}

void write_elements(const Model& model, Text& out) {
  std::size_t n = 0;
  Index low = 0, high = 0;
  for (const auto& entity : model.entities) {
    n += entity.elements.size();
    for (const auto& row : entity.elements) {
      low = low == 0 ? row.id : std::min(low, row.id);
      high = std::max(high, row.id);
    }
  }
  out << "$Elements\n" << model.entities.size() << " " << n << " " << low << " " << high << "\n";
  std::array<Index, 4> tag{};
  for (const auto& entity : model.entities) {
    out << entity.dimension << " " << ++tag[entity.dimension] << " " << entity.type << " "
        << entity.elements.size() << "\n";
    for (const auto& row : entity.elements) {
      out << row.id;
      for (const Index node : row.nodes) out << " " << node;
      out << "\n";
    }
  }
  out << "$EndElements\n";
}

}  // namespace

void write_gmsh(const Mesh& mesh, const std::filesystem::path& file, const std::string& where) {
  const Model model = Builder(mesh).build();
  if (model.entities.empty() || mesh.node_ids.empty())
    throw InputError(where + ": a mesh without elements cannot be written");
  if (*std::min_element(mesh.node_ids.begin(), mesh.node_ids.end()) < 1)
    throw InputError(where + ": a .msh file needs node ids from 1");
  errno = 0;  // of the first write that fails: none follows it
  Text out(file);
  out << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Comments\n"
      << gmsh_mark << "$EndComments\n$PhysicalNames\n"
      << model.physical.size() << "\n";
  for (const auto& p : model.physical)
    out << p.dimension << " " << p.tag << " \"" << p.name << "\"\n";
  out << "$EndPhysicalNames\n";
  write_entities(mesh, model, out);
  write_nodes(mesh, model, out);
  write_elements(model, out);
  if (!out.finish())
    throw RunError(where + ": cannot be written" +
                   (errno != 0 ? ": " + std::string(std::strerror(errno)) : ""));
}

}  // namespace cbr
