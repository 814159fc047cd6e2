// SPDX-License-Identifier: GPL-3.0-or-later
// Reads MED 3 and 4, the format of Salome and code_aster: HDF5 in the layout of libmed. Cells of a
// mesh by their type, nodes component by component, groups by way of families: each node and cell
// has one family, each family any number of groups. Node orders: "Modelisation des donnees MED",
// section on reference elements.
#include <algorithm>
#include <unordered_set>
#include <utility>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/mesh/io/file_mesh.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

// order: node i of Exodus II is node order[i] of MED, but for the sense (see outward_order).
struct MedType {
  const char* name;
  int n_nodes;
  std::optional<ElementType> type;  // none: points and curves
  std::vector<int> order;
};

// In MED's order, which is that of numbers where a file gives none.
const std::vector<MedType>& med_types() {
  using enum ElementType;
  static const std::vector<MedType> types = {
      {"PO1", 1, {}, {}},
      {"SE2", 2, {}, {}},
      {"SE3", 3, {}, {}},
      {"SE4", 4, {}, {}},
      {"TR3", 3, tri3, {}},
      {"QU4", 4, quad4, {}},
      {"TR6", 6, tri6, {}},
      {"QU8", 8, quad8, {}},
      {"QU9", 9, quad9, {}},
      {"TE4", 4, tet4, {}},
      {"PY5", 5, pyramid5, {}},
      {"PE6", 6, wedge6, {}},
      {"HE8", 8, hex8, {}},
      {"T10", 10, tet10, {}},
      // the edges of the upper face come before the upright ones
      {"P15", 15, wedge15, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11}},
      {"H20", 20, hex20, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15}},
      // then the faces: bottom, front, right, back, left, top; the centre
      {"H27", 27, hex27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 16, 17,
                          18, 19, 12, 13, 14, 15, 26, 20, 25, 24, 22, 21, 23}},
  };
  return types;
}

const MedType* find_type(const std::string& name) {
  for (const MedType& type : med_types())
    if (type.name == name) return &type;
  return nullptr;
}

// Six times the volume that the sides enclose, by the nodes' coordinates.
double volume_of(ElementType type, const std::vector<Vector3>& corners) {
  double volume = 0;
  for (int s = 1; s <= n_sides(type); ++s) {
    const std::vector<int>& side = side_nodes(type, s);
    const auto at = [&](int i) { return corners[side[i]] - corners[0]; };
    for (int i = 2; i < n_corners(side_kind(type, s)); ++i)
      volume += at(0).dot(at(i - 1).cross(at(i)));
  }
  return volume;
}

// Spaces and NUL at the end are padding. Text that is no UTF-8 is Latin-1, as of older Salome.
std::string utf8(std::string text) {
  text = text.substr(0, text.find('\0'));
  text.erase(text.find_last_not_of(' ') + 1);
  bool is_utf8 = true;
  for (std::size_t i = 0; i < text.size() && is_utf8;) {
    const auto first = static_cast<unsigned char>(text[i++]);
    int more = first < 0x80 ? 0 : first < 0xC2 ? -1 : first < 0xE0 ? 1 : first < 0xF0 ? 2 : 3;
    for (is_utf8 = more >= 0 && first < 0xF5; is_utf8 && more > 0; --more)
      is_utf8 = i < text.size() && (static_cast<unsigned char>(text[i++]) & 0xC0) == 0x80;
  }
  if (is_utf8) return text;
  std::string wide;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      wide += c;
    } else {
      wide += static_cast<char>(0xC0 | (byte >> 6));
      wide += static_cast<char>(0x80 | (byte & 0x3F));
    }
  }
  return wide;
}

using Groups = std::map<Index, std::vector<std::string>>;  // of a family, by its number

struct Cells {
  const MedType* type = nullptr;
  std::vector<Index> nodes;   // places, the file's order: first nodes of all cells, second ...
  std::vector<Index> family;  // one a cell
  std::vector<Index> number;  // empty: the file has none
  Index size() const { return static_cast<Index>(family.size()); }
};

class MedMesh {
 public:
  explicit MedMesh(const std::filesystem::path& file) : file_(file) { mesh_.where = file.string(); }

  Mesh run() {
    find_mesh();
    read_nodes();
    node_groups_ = read_families("NOEUD");
    cell_groups_ = read_families("ELEME");
    read_cells();
    number_cells();
    for (const Cells& cells : cells_) {
      if (!cells.type->type)
        add_curves(cells);
      else if (dimension(*cells.type->type) == 3)
        add_solids(cells);
      else
        add_faces(cells);
    }
    std::vector<FaceSet> faces;
    for (const auto& [name, elements] : faces_) faces.push_back({name, elements});
    Mesh mesh = mesh_of(mesh_, faces);
    add_node_groups();
    for (auto& [name, nodes] : nodesets_) add_nodeset(mesh, name, std::move(nodes));
    return mesh;
  }

 private:
  [[noreturn]] void fail(const std::string& object, const std::string& what) const {
    throw InputError(mesh_.where + ": " + object + ": " + what);
  }

  void find_mesh() {
    if (!file_.has("/INFOS_GENERALES") || !file_.has("/ENS_MAA"))
      throw InputError(mesh_.where + ": holds no mesh of MED (/INFOS_GENERALES, /ENS_MAA)");
    if (file_.read_index("/INFOS_GENERALES", "MAJ") < 3)
      throw InputError(mesh_.where +
                       ": is of MED 2, MED 3 and later are read: convert it with medimport "
                       "(Debian: libmed-tools), or save it again in Salome");
    const std::vector<std::string> meshes = file_.children("/ENS_MAA");
    if (meshes.size() != 1)
      fail("/ENS_MAA", "holds " + std::to_string(meshes.size()) + " meshes (" + join(meshes) +
                           "), expected one: save it in a file of its own");
    name_ = meshes[0];
    const std::string mesh = "/ENS_MAA/" + name_;
    if (file_.read_index(mesh, "TYP") != 0)
      fail(mesh, "is a grid (TYP), expected a mesh of elements");
    if (file_.read_index(mesh, "ESP") != 3)
      fail(mesh, "has " + std::to_string(file_.read_index(mesh, "ESP")) +
                     " coordinates a node (ESP), expected 3");
    if (file_.has_attribute(mesh, "REP") && file_.read_index(mesh, "REP") != 0)
      fail(mesh, "has polar coordinates (REP), expected x, y, z");
    const std::vector<std::string> steps = file_.children(mesh);
    if (steps.size() != 1)
      fail(mesh, "holds the mesh at " + std::to_string(steps.size()) + " times, expected one");
    base_ = mesh + "/" + steps[0];
  }

  // Numbers that the file gives its nodes or cells, or none. Some programs write them anew from 1
  // in each type; see number_cells().
  std::vector<Index> read_numbers(const std::string& object, Index n) const {
    if (!file_.has(object)) return {};
    std::vector<Index> numbers = file_.read_indices(object);
    require_size(object, static_cast<Index>(numbers.size()), n);
    return numbers;
  }

  void require_size(const std::string& object, Index found, Index expected) const {
    if (found != expected)
      fail(object, "has " + std::to_string(found) + " entries, expected " +
                       std::to_string(expected) + ": damaged");
  }

  void read_nodes() {
    const std::string object = base_ + "/NOE/COO";
    const Vector values = file_.read_vector(object);
    n_ = values.size() / 3;
    if (n_ == 0 || values.size() % 3 != 0)
      fail(object, "has " + std::to_string(values.size()) + " numbers, expected three a node");
    if (file_.has_attribute(object, "NBR"))
      require_size(object, n_, file_.read_index(object, "NBR"));
    mesh_.coordinates.resize(3 * n_);
    for (Index i = 0; i < n_; ++i)
      for (Index c = 0; c < 3; ++c) mesh_.coordinates[3 * i + c] = values[c * n_ + i];
    mesh_.node_ids = read_numbers(base_ + "/NOE/NUM", n_);
    for (const Index id : mesh_.node_ids)
      if (id < 1)
        fail(base_ + "/NOE/NUM",
             "node number " + std::to_string(id) + " found, expected from 1 on");
    if (mesh_.node_ids.empty())
      for (Index i = 1; i <= n_; ++i) mesh_.node_ids.push_back(i);
  }

  Groups read_families(const std::string& kind) const {
    Groups groups{{0, {}}};
    const std::string folder = "/FAS/" + name_ + "/" + kind;
    if (!file_.has(folder)) return groups;
    for (const std::string& child : file_.children(folder)) {
      const std::string family = folder + "/" + child, names = family + "/GRO/NOM";
      std::vector<std::string>& of_family = groups[file_.read_index(family, "NUM")];
      if (!file_.has(names)) continue;
      for (const std::string& text : file_.read_texts(names))
        if (const std::string name = utf8(text); !name.empty()) of_family.push_back(name);
    }
    return groups;
  }

  // Families of nodes or cells; without the dataset all are in none.
  std::vector<Index> read_family(const std::string& object, Index n, const Groups& groups) const {
    if (!file_.has(object)) return std::vector<Index>(n, 0);
    std::vector<Index> family = file_.read_indices(object);
    require_size(object, static_cast<Index>(family.size()), n);
    for (const Index number : family)
      if (groups.count(number) == 0)
        fail(object, "family " + std::to_string(number) + " found, which /FAS/" + name_ +
                         " does not have: damaged");
    return family;
  }

  void read_cells() {
    const std::string folder = base_ + "/MAI";
    if (!file_.has(folder)) fail(folder, "missing: the mesh has no elements");
    for (const std::string& child : file_.children(folder))
      if (find_type(child) == nullptr) refuse_type(folder, child);
    for (const MedType& type : med_types()) {
      const std::string object = folder + "/" + type.name, nodes = object + "/NOD";
      if (!file_.has(object)) continue;
      Cells cells{.type = &type, .nodes = file_.read_indices(nodes)};
      const auto n = static_cast<Index>(cells.nodes.size()) / type.n_nodes;
      if (static_cast<Index>(cells.nodes.size()) % type.n_nodes != 0)
        fail(nodes, "has " + std::to_string(cells.nodes.size()) + " entries, expected " +
                        std::to_string(type.n_nodes) + " an element: damaged");
      if (file_.has_attribute(nodes, "NBR")) require_size(nodes, n, file_.read_index(nodes, "NBR"));
      for (Index& node : cells.nodes) {
        if (node < 1 || node > n_)
          fail(nodes, "node " + std::to_string(node) + " found, allowed are 1 to " +
                          std::to_string(n_) + ": damaged");
        --node;
      }
      cells.family = read_family(object + "/FAM", n, cell_groups_);
      cells.number = read_numbers(object + "/NUM", n);
      cells_.push_back(std::move(cells));
    }
  }

  [[noreturn]] void refuse_type(const std::string& folder, const std::string& name) const {
    std::vector<std::string> names;
    for (const MedType& type : med_types()) names.emplace_back(type.name);
    fail(folder, "element type " + name + " is not supported: use " + join(names));
  }

  // The file's numbers if they are unique in the mesh, else counted from 1 through all types.
  void number_cells() {
    std::unordered_set<Index> seen;
    const bool all = std::all_of(cells_.begin(), cells_.end(), [&](const Cells& cells) {
      return static_cast<Index>(cells.number.size()) == cells.size() &&
             std::all_of(cells.number.begin(), cells.number.end(),
                         [&](Index number) { return number > 0 && seen.insert(number).second; });
    });
    if (all) return;
    Index next = 1;
    for (Cells& cells : cells_) {
      cells.number.resize(cells.family.size());
      for (Index& number : cells.number) number = next++;
    }
  }

  const std::vector<std::string>& groups_of(const Cells& cells, Index cell) const {
    return cell_groups_.at(cells.family[cell]);
  }

  // Places of the nodes of a cell, in the order of Exodus II but for the sense.
  std::vector<Index> nodes_of(const Cells& cells, Index cell) const {
    std::vector<Index> nodes(cells.type->n_nodes);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Index a = cells.type->order.empty() ? static_cast<Index>(i) : cells.type->order[i];
      nodes[i] = cells.nodes[a * cells.size() + cell];
    }
    return nodes;
  }

  Vector3 position(Index node) const {
    return Eigen::Map<const Vector3>(mesh_.coordinates.data() + 3 * node);
  }

  // The first face of a solid of MED looks inwards, but not every program knows. The volume
  // decides; without one it is as MED says.
  std::vector<Index> outward_order(ElementType type, const std::vector<Index>& nodes) const {
    std::vector<Vector3> corners;
    for (int i = 0; i < n_corners(type); ++i) corners.push_back(position(nodes[i]));
    if (volume_of(type, corners) > 0) return nodes;
    std::vector<Index> turned;
    for (const int i : mirrored_order(type)) turned.push_back(nodes[i]);
    return turned;
  }

  std::size_t add_element(const Cells& cells, Index cell, const std::string& block,
                          const std::vector<Index>& nodes) {
    mesh_.elements.push_back(
        {cells.number[cell], *cells.type->type, mesh_.element_nodes.size(), block});
    for (const Index node : nodes) mesh_.element_nodes.push_back(mesh_.node_ids[node]);
    return mesh_.elements.size() - 1;
  }

  // Of several groups the smallest counts: a part of the whole, not the whole.
  std::string block_of(const std::vector<std::string>& groups) {
    if (n_solids_.empty()) count_solids();
    if (groups.empty()) return "volume";
    return *std::min_element(groups.begin(), groups.end(),
                             [&](const std::string& a, const std::string& b) {
                               return std::pair(n_solids_[a], a) < std::pair(n_solids_[b], b);
                             });
  }

  void count_solids() {
    for (const Cells& cells : cells_)
      if (cells.type->type && dimension(*cells.type->type) == 3)
        for (Index cell = 0; cell < cells.size(); ++cell)
          for (const std::string& group : groups_of(cells, cell)) ++n_solids_[group];
  }

  void add_solids(const Cells& cells) {
    std::map<Index, std::string> blocks;  // of a family
    for (Index cell = 0; cell < cells.size(); ++cell) {
      const Index family = cells.family[cell];
      auto block = blocks.find(family);
      if (block == blocks.end())
        block = blocks.emplace(family, block_of(groups_of(cells, cell))).first;
      add_element(cells, cell, block->second,
                  outward_order(*cells.type->type, nodes_of(cells, cell)));
    }
  }

  // Faces of no group are left out: programs for meshes write all outer faces.
  void add_faces(const Cells& cells) {
    for (Index cell = 0; cell < cells.size(); ++cell) {
      const std::vector<std::string>& groups = groups_of(cells, cell);
      if (groups.empty()) continue;
      const std::size_t place = add_element(cells, cell, groups[0], nodes_of(cells, cell));
      for (const std::string& group : groups) faces_[group].push_back(place);
    }
  }

  void add_curves(const Cells& cells) {
    for (Index cell = 0; cell < cells.size(); ++cell)
      for (const std::string& group : groups_of(cells, cell))
        for (const Index node : nodes_of(cells, cell)) nodesets_[group].push_back(node);
  }

  void add_node_groups() {
    const std::vector<Index> family = read_family(base_ + "/NOE/FAM", n_, node_groups_);
    for (Index i = 0; i < n_; ++i)
      for (const std::string& group : node_groups_.at(family[i])) nodesets_[group].push_back(i);
  }

  Hdf5Reader file_;
  FileMesh mesh_;
  std::string name_, base_;  // of the mesh; the group of its nodes and cells
  Index n_ = 0;              // nodes
  Groups node_groups_, cell_groups_;
  std::vector<Cells> cells_;
  std::map<std::string, Index> n_solids_;  // in a group
  std::map<std::string, std::vector<std::size_t>> faces_;
  std::map<std::string, std::vector<Index>> nodesets_;
};

}  // namespace

Mesh read_med(const std::filesystem::path& file) { return MedMesh(file).run(); }

}  // namespace cbr
