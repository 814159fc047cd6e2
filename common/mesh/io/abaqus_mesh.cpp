// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh from an input file of Abaqus or CalculiX. Sections become blocks, surfaces and
// sets of face elements sidesets, node sets nodesets.
#include <algorithm>
#include <set>

#include "common/mesh/io/inp_file.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

// Exodus's number of face S<label> (from 1) of a solid, or 0.
int exodus_side(ElementType type, int label) {
  // By the number of the type's corners: those of the faces S1, S2, ..., local numbers from 0
  static const std::map<int, std::vector<std::vector<int>>> all = {
      {4, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}},
      {5, {{0, 1, 2, 3}, {0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}}},
      {6, {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}},
      {8, {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}}}};
  if (dimension(type) != 3 || label < 1 || label > n_sides(type)) return 0;
  const auto& faces = all.at(n_corners(type));
  const auto& corners = faces[label - 1];
  const std::set<int> wanted(corners.begin(), corners.end());
  for (int side = 1; side <= n_sides(type); ++side) {
    const auto& nodes = side_nodes(type, side);
    if (std::set<int>(nodes.begin(), nodes.begin() + n_corners(side_kind(type, side))) == wanted)
      return side;
  }
  return 0;
}

class AbaqusMesh {
 public:
  explicit AbaqusMesh(const std::filesystem::path& file) : file_(read_inp(file)) {}

  Mesh run() {
    for (std::size_t e = 0; e < file_.mesh.elements.size(); ++e)
      place_.emplace(file_.mesh.elements[e].id, e);
    for (const InpSection& section : file_.sections) add_section(section);
    for (FileElement& element : file_.mesh.elements)
      if (element.block.empty()) element.block = dimension(element.type) == 3 ? "solid" : "shell";
    mesh_ = mesh_of(file_.mesh, face_sets());
    const MeshIds ids(mesh_);
    for (const std::string& name : file_.nset_order) add_nodes(file_.nsets.at(name), ids);
    for (const std::string& name : file_.elset_order) add_lines(file_.elsets.at(name), ids);
    for (const InpSurface& surface : file_.surfaces)
      surface.of_nodes ? add_node_surface(surface, ids) : add_surface(surface, ids);
    add_points(ids);
    mesh_.dropped = file_.dropped;
    return std::move(mesh_);
  }

 private:
  const InpSet& elset(const std::string& name, const DeckPlace& place) const {
    const auto found = file_.elsets.find(name);
    if (found == file_.elsets.end()) place.fail("there is no element set '" + name + "'");
    return found->second;
  }

  void add_section(const InpSection& section) {
    const InpSet& set = elset(section.elset, section.place);
    for (const Index id : set.ids) {
      if (file_.lines.count(id) > 0)
        section.place.fail(
            "element " + std::to_string(id) +
            " is a beam or truss, which are not supported: take them out of the mesh");
      const auto found = place_.find(id);
      if (found == place_.end())
        section.place.fail("element " + std::to_string(id) + " of set '" + set.name +
                           "' does not exist");
      if (section_of_.try_emplace(id, &section).first->second != &section)
        section.place.fail("element " + std::to_string(id) +
                           " has two sections: take it out of one of their sets (CalculiX takes "
                           "the last)");
      file_.mesh.elements[found->second].block = set.name;
    }
    const auto known = file_.materials.find(section.material);
    FileMaterial& material = file_.mesh.materials[set.name] =
        known != file_.materials.end()
            ? known->second
            : FileMaterial{.name = section.material, .problem = "is not defined in the file"};
    if (!section.orientation.empty() && !material.engineering_constants.empty())
      orient(section, material);
  }

  void orient(const InpSection& section, FileMaterial& material) const {
    const auto found = file_.orientations.find(section.orientation);
    if (found == file_.orientations.end())
      section.place.fail("there is no *ORIENTATION '" + section.orientation + "'");
    material.axis = found->second.axis;
    material.in_plane = found->second.in_plane;
    material.center = found->second.center;
    if (!found->second.problem.empty()) material.problem = found->second.problem;
  }

  bool is_name_of_surface(const std::string& name) const {
    return std::any_of(
        file_.surfaces.begin(), file_.surfaces.end(),
        [&](const InpSurface& surface) { return in_capitals(surface.name) == in_capitals(name); });
  }

  // Element sets of faces alone, and surfaces of them.
  std::vector<FaceSet> face_sets() const {
    std::vector<FaceSet> sets;
    for (const std::string& name : file_.elset_order) {
      const InpSet& set = file_.elsets.at(name);
      FaceSet faces{set.name, faces_in(set.ids)};
      if (!faces.elements.empty() && faces.elements.size() == set.ids.size() &&
          !is_name_of_surface(name))
        sets.push_back(faces);
    }
    for (const InpSurface& surface : file_.surfaces) {
      FaceSet faces{surface.name, {}};
      for (const auto& entry : surface.entries) {
        if (surface.of_nodes || (entry.label.starts_with("S") && entry.label.size() == 2)) continue;
        const std::vector<std::size_t> more = faces_in(ids_of(entry));
        faces.elements.insert(faces.elements.end(), more.begin(), more.end());
      }
      if (!faces.elements.empty()) sets.push_back(faces);
    }
    return sets;
  }

  std::vector<std::size_t> faces_in(const std::vector<Index>& ids) const {
    std::vector<std::size_t> places;
    for (const Index id : ids) {
      const auto found = place_.find(id);
      if (found != place_.end() && dimension(file_.mesh.elements[found->second].type) == 2)
        places.push_back(found->second);
    }
    return places;
  }

  std::vector<Index> ids_of(const InpSurface::Entry& entry) const {
    return entry.set.empty() ? std::vector<Index>{entry.id} : elset(entry.set, entry.place).ids;
  }

  static Index node(Index id, const std::string& set, const DeckPlace& place, const MeshIds& ids) {
    const Index found = ids.node(id);
    if (found < 0)
      place.fail("node " + std::to_string(id) + " of set '" + set + "' does not exist");
    return found;
  }

  void add_nodes(const InpSet& set, const MeshIds& ids) {
    std::vector<Index> nodes;
    for (const Index id : set.ids) nodes.push_back(node(id, set.name, set.place, ids));
    for (const std::string& name : set.elsets) {
      for (const Index id : elset(name, set.place).ids) {
        const auto found = place_.find(id);  // also of faces of solids, which are no elements here
        if (found == place_.end()) continue;
        const FileElement& element = file_.mesh.elements[found->second];
        for (int a = 0; a < n_nodes(element.type); ++a)
          nodes.push_back(node(file_.mesh.element_nodes[element.first + a], name, set.place, ids));
      }
    }
    if (!set.internal) add_nodeset(mesh_, set.name, nodes);
  }

  // Curves, which programs for meshes write as beams.
  void add_lines(const InpSet& set, const MeshIds& ids) {
    std::vector<Index> nodes;
    for (const Index id : set.ids) {
      const auto line = file_.lines.find(id);
      if (line == file_.lines.end()) return;
      for (const Index its : line->second) nodes.push_back(node(its, set.name, set.place, ids));
    }
    if (!nodes.empty() && !set.internal) add_nodeset(mesh_, set.name, nodes);
  }

  void add_node_surface(const InpSurface& surface, const MeshIds& ids) {
    std::vector<Index> nodes;
    for (const auto& entry : surface.entries) {
      const auto set = file_.nsets.find(entry.set);
      if (!entry.set.empty() && set == file_.nsets.end())
        entry.place.fail("there is no node set '" + entry.set + "'");
      const std::vector<Index> members =
          entry.set.empty() ? std::vector<Index>{entry.id} : set->second.ids;
      for (const Index id : members) nodes.push_back(node(id, surface.name, entry.place, ids));
    }
    add_nodeset(mesh_, surface.name, nodes);
  }

  void add_surface(const InpSurface& surface, const MeshIds& ids) {
    if (find_sideset(mesh_, surface.name) >= 0) return;  // of face elements
    Sideset set{surface.name, static_cast<Index>(mesh_.sidesets.size()) + 1, {}};
    for (const auto& entry : surface.entries) {
      for (const Index id : ids_of(entry)) {
        const Side element = ids.element(id);
        if (element.element < 0)
          entry.place.fail("element " + std::to_string(id) + " of surface '" + surface.name +
                           "' does not exist");
        entry.label.empty() ? add_outer_sides(element, set) : add_side(element, entry, set);
      }
    }
    mesh_.sidesets.push_back(std::move(set));
  }

  // Of *COUPLING, *DISTRIBUTING COUPLING and *RIGID BODY.
  void add_points(const MeshIds& ids) {
    if (file_.constraints.empty() && file_.masses.empty()) return;
    const std::unordered_set<Index> used = used_nodes(file_.mesh);
    FilePoints points;
    for (const InpConstraint& of : file_.constraints) {
      const Index node = reference_of(of);
      const bool is_own = node > 0;
      if (is_own ? ids.node(node) < 0 : !file_.assembly_nodes.contains(-node))
        of.place.fail("there is no reference node " + std::to_string(std::abs(node)));
      if (is_own && used.contains(node))
        of.place.fail("the reference node " + std::to_string(node) +
                      " is a node of an element: give it a node of its own");
      points.add(node, {set_of(of),
                        is_own ? Vector3(mesh_.coordinates.row(ids.node(node)))
                               : file_.assembly_nodes.at(-node),
                        of.rigid, of.place});
    }
    for (const InpMass& of : file_.masses)
      for (const Index id : elset(of.elset, of.place).ids)
        if (const auto found = file_.point_elements.find(id); found != file_.point_elements.end())
          points.masses.push_back(
              {"", found->second, of.mass, of.inertia, Vector3::Zero(), of.place});
    cbr::add_points(points, mesh_);
  }

  // Below 0: of the assembly.
  Index reference_of(const InpConstraint& of) const {
    for (const auto* sets : {&file_.assembly_sets, &file_.nsets}) {
      const auto found = sets->find(of.node);
      if (found == sets->end()) continue;
      if (found->second.ids.size() != 1)
        of.place.fail("the set '" + of.node + "' of the reference node holds " +
                      std::to_string(found->second.ids.size()) + " nodes, expected 1");
      return sets == &file_.nsets ? found->second.ids.front() : -found->second.ids.front();
    }
    if (of.node.size() > 15 || of.node.find_first_not_of("0123456789") != std::string::npos)
      of.place.fail("there is no node set '" + of.node + "', expected a node's number or a set");
    const Index id = std::stoll(of.node);
    return of.of_assembly && file_.assembly_nodes.contains(id) ? -id : id;
  }

  std::string set_of(const InpConstraint& of) const {
    if (!of.is_complete) of.place.fail("*COUPLING without *KINEMATIC or *DISTRIBUTING after it");
    const std::size_t least = of.rigid ? 3 : 6;  // nodes of solids have no other motions
    const auto n = std::count(of.motions.begin(), of.motions.begin() + least, true);
    if (n != 0 && n != static_cast<std::ptrdiff_t>(least))
      of.place.fail("*COUPLING joins some of the motions 1 to " + std::to_string(least) +
                    ": not in this version; use all of them, or a point of the set (*DISTRIBUTING) "
                    "and a link of the scene from it (links[].fix)");
    for (const InpSurface& surface : file_.surfaces)
      if (in_capitals(surface.name) == of.set) return surface.name;
    const auto found = file_.nsets.find(of.set);
    if (found == file_.nsets.end()) of.place.fail("there is no set '" + of.set + "'");
    return found->second.name;
  }

  void add_side(Side element, const InpSurface::Entry& entry, Sideset& set) const {
    const ElementType type = mesh_.blocks[element.block].type;
    const bool is_face = entry.label.size() == 2 && entry.label[0] == 'S';
    if (is_face) element.side = exodus_side(type, entry.label[1] - '0');
    if (dimension(type) == 2)
      element.side = shell_side(element, is_face ? entry.label[1] - '0' : 0, entry.label);
    if (element.side == 0)
      entry.place.fail(
          "face '" + entry.label +
          "' found, expected S1, S2, ... of a solid element, or SPOS, SNEG of a shell");
    set.sides.push_back(element);
  }

  // Of a plane element S1, S2, ... are edges; of a shell S1 and SNEG, S2 and SPOS are faces, and
  // edges follow, as in CalculiX. 0: none.
  int shell_side(const Side& element, int label, const std::string& word) const {
    const Block& block = mesh_.blocks[element.block];
    const bool is_plane = file_.plane_elements.contains(block.element_ids[element.element]);
    if (word == "SPOS" || (label == 2 && !is_plane)) return 1;
    if (word == "SNEG" || (label == 1 && !is_plane)) return 2;
    const int side = is_plane ? label + 2 : label;
    return label > 0 && side <= 2 + n_corners(block.type) ? side : 0;
  }

  // Sides that no other solid shares.
  void add_outer_sides(Side element, Sideset& set) {
    if (n_shared_.empty()) count_sides();
    for (element.side = 1; element.side <= n_sides(mesh_.blocks[element.block].type);
         ++element.side)
      if (n_shared_.at(key_of(element)) == 1) set.sides.push_back(element);
  }

  std::vector<Index> key_of(const Side& side) const {
    std::vector<Index> nodes = nodes_of_side(mesh_, side);
    std::sort(nodes.begin(), nodes.end());
    return nodes;
  }

  void count_sides() {
    for (std::size_t b = 0; b < mesh_.blocks.size(); ++b) {
      const Block& block = mesh_.blocks[b];
      if (dimension(block.type) != 3) continue;
      for (Index e = 0; e < block.connectivity.rows(); ++e)
        for (int side = 1; side <= n_sides(block.type); ++side)
          ++n_shared_[key_of({static_cast<Index>(b), e, side})];
    }
  }

  InpFile file_;
  Mesh mesh_;
  std::unordered_map<Index, std::size_t> place_;  // of an element in FileMesh::elements
  std::map<Index, const InpSection*> section_of_;
  std::map<std::vector<Index>, int> n_shared_;
};

}  // namespace

Mesh read_abaqus_mesh(const std::filesystem::path& file) { return AbaqusMesh(file).run(); }

}  // namespace cbr
