// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/io/file_mesh.hpp"

#include <algorithm>
#include <set>
#include <tuple>

#include "common/base/error.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

class MeshMaker {
 public:
  MeshMaker(const FileMesh& file, const std::vector<FaceSet>& faces) : file_(file), faces_(faces) {}

  Mesh run() {
    load_nodes();
    std::vector<std::size_t> solids;
    for (std::size_t e = 0; e < file_.elements.size(); ++e)
      if (dimension(file_.elements[e].type) == 3) solids.push_back(e);
    add_blocks(solids);
    add_sidesets();
    std::vector<std::size_t> shells;
    for (std::size_t e = 0; e < file_.elements.size(); ++e)
      if (dimension(file_.elements[e].type) == 2 && is_side_.count(e) == 0) shells.push_back(e);
    add_blocks(shells);
    return std::move(mesh_);
  }

 private:
  void load_nodes() {
    const auto n = static_cast<Index>(file_.node_ids.size());
    mesh_.node_ids = file_.node_ids;
    mesh_.coordinates = Eigen::Map<const Points>(file_.coordinates.data(), n, 3);
    for (Index i = 0; i < n; ++i) index_.emplace(mesh_.node_ids[i], i);
  }

  std::vector<Index> nodes_of(const FileElement& element) const {
    std::vector<Index> nodes;
    for (std::size_t a = 0; a < static_cast<std::size_t>(n_nodes(element.type)); ++a) {
      const Index id = file_.element_nodes[element.first + a];
      const auto found = index_.find(id);
      if (found == index_.end())
        throw InputError(file_.where + ": element " + std::to_string(element.id) +
                         " refers to node " + std::to_string(id) +
                         ", which the file does not define");
      nodes.push_back(found->second);
    }
    return nodes;
  }

  // In the order in which blocks, and their types, come in the file.
  void add_blocks(const std::vector<std::size_t>& elements) {
    using Key = std::tuple<std::string, ElementType, bool>;
    std::map<Key, std::size_t> place;
    std::map<std::string, int> n_types;
    std::vector<std::vector<std::size_t>> groups;
    for (const std::size_t e : elements) {
      const FileElement& one = file_.elements[e];
      const auto [found, is_new] =
          place.emplace(Key(one.block, one.type, one.reduced), groups.size());
      if (is_new) {
        groups.emplace_back();
        if (!place.contains(Key(one.block, one.type, !one.reduced))) ++n_types[one.block];
      }
      groups[found->second].push_back(e);
    }
    for (const std::vector<std::size_t>& members : groups) {
      const FileElement& one = file_.elements[members.front()];
      const bool is_both = place.contains(Key(one.block, one.type, !one.reduced));
      add_block(members, (n_types[one.block] > 1 ? "_" + std::string(name(one.type)) : "") +
                             (is_both && one.reduced ? "_reduced" : ""));
    }
  }

  void add_block(const std::vector<std::size_t>& members, const std::string& suffix) {
    const auto& [id, type, first, group, reduced] = file_.elements[members.front()];
    Block block;
    block.name = group + suffix;
    block.reduced = reduced;
    block.id = static_cast<Index>(mesh_.blocks.size()) + 1;
    block.type = type;
    block.connectivity.resize(static_cast<Index>(members.size()), n_nodes(type));
    for (std::size_t row = 0; row < members.size(); ++row) {
      const FileElement& element = file_.elements[members[row]];
      const std::vector<Index> nodes = nodes_of(element);
      std::copy(nodes.begin(), nodes.end(),
                block.connectivity.row(static_cast<Index>(row)).begin());
      block.element_ids.push_back(element.id);
    }
    if (const auto material = file_.materials.find(group); material != file_.materials.end())
      block.material = material->second;
    mesh_.blocks.push_back(std::move(block));
  }

  void add_sidesets() {
    std::vector<bool> wanted(mesh_.node_ids.size(), false);
    for (const FaceSet& set : faces_)
      for (const std::size_t e : set.elements)
        for (const Index node : nodes_of(file_.elements[e])) wanted[node] = true;
    const SideLookup lookup(mesh_, wanted);
    for (const FaceSet& set : faces_) add_sideset(set, lookup);
  }

  void add_sideset(const FaceSet& set, const SideLookup& lookup) {
    Sideset sideset{set.name, static_cast<Index>(mesh_.sidesets.size()) + 1, {}};
    std::set<std::tuple<Index, Index, int>> seen;
    for (const std::size_t e : set.elements) {
      const FileElement& element = file_.elements[e];
      std::vector<Index> corners = nodes_of(element);
      corners.resize(n_corners(element.type));
      const Side side = lookup.find(corners);
      if (side.element < 0) return;  // shells, which are no surface of a solid
      if (seen.insert({side.block, side.element, side.side}).second) sideset.sides.push_back(side);
    }
    is_side_.insert(set.elements.begin(), set.elements.end());
    mesh_.sidesets.push_back(std::move(sideset));
  }

  const FileMesh& file_;
  const std::vector<FaceSet>& faces_;
  Mesh mesh_;
  std::unordered_map<Index, Index> index_;
  std::set<std::size_t> is_side_;
};

}  // namespace

Mesh mesh_of(const FileMesh& file, const std::vector<FaceSet>& faces) {
  return MeshMaker(file, faces).run();
}

MeshIds::MeshIds(const Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.node_ids.size(); ++i)
    nodes_.emplace(mesh.node_ids[i], static_cast<Index>(i));
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const auto& ids = mesh.blocks[b].element_ids;
    for (std::size_t e = 0; e < ids.size(); ++e)
      elements_.emplace(ids[e], Side{static_cast<Index>(b), static_cast<Index>(e), 0});
  }
}

Index MeshIds::node(Index id) const {
  const auto found = nodes_.find(id);
  return found == nodes_.end() ? -1 : found->second;
}

Side MeshIds::element(Index id) const {
  const auto found = elements_.find(id);
  return found == elements_.end() ? Side{-1, -1, 0} : found->second;
}

void FilePoints::add(Index node, Point point) {
  const auto [other, is_new] = points.emplace(node, point);
  if (!is_new)
    point.place.fail("node " + std::to_string(std::abs(node)) + " is the reference of line " +
                     std::to_string(other->second.place.line) +
                     " too: write one constraint with all of its nodes");
}

void add_points(const FilePoints& all, Mesh& mesh) {
  constexpr double singular = 1e-12;
  const auto make = [](const FilePoints::Point& of, const Vector3& at, bool rigid) {
    return MeshPoint{of.nodes, at, rigid, 0, Matrix3::Zero(), *of.place.file, of.place.line};
  };
  const auto name_of = [](Index node) { return "node_" + std::to_string(std::abs(node)); };
  for (const auto& [node, of] : all.points)
    if (!mesh.points.emplace(name_of(node), make(of, of.at, of.rigid)).second)
      of.place.fail("the part and the assembly have a reference node " + std::to_string(node) +
                    ": renumber one of the two");
  for (const FilePoints::Mass& mass : all.masses) {
    const auto found = all.points.find(mass.node);
    if (found == all.points.end())
      mass.place.fail(
          "a mass on node " + std::to_string(std::abs(mass.node)) +
          " found, expected on the reference node of a rigid or distributing constraint (RBE2, "
          "RBE3, *COUPLING, *DISTRIBUTING COUPLING, *RIGID BODY): masses of other nodes are not in "
          "this version; use one of these to join the mass to a face");
    const Matrix3& J = mass.inertia;
    const double size = J.diagonal().maxCoeff(), second = J.topLeftCorner<2, 2>().determinant();
    const bool is_definite = J(0, 0) > singular * size && second > singular * size * size &&
                             J.determinant() > singular * size * size * size;
    if (mass.mass < 0 || J.diagonal().minCoeff() < 0 || (!J.isDiagonal(0) && !is_definite))
      mass.place.fail("is no mass: expected one from 0 and a positive definite inertia");
    // A point beside the node has the mean motion of the same set, which is that of a rigid one
    const FilePoints::Point& of = found->second;
    MeshPoint& point =
        mass.offset.isZero(0)
            ? mesh.points.at(name_of(mass.node))
            : mesh.points.emplace(mass.name, make(of, of.at + mass.offset, false)).first->second;
    point.mass += mass.mass;
    point.inertia += mass.inertia;
  }
}

std::unordered_set<Index> used_nodes(const FileMesh& file) {
  return {file.element_nodes.begin(), file.element_nodes.end()};
}

void add_nodeset(Mesh& mesh, const std::string& name, std::vector<Index> nodes, Index id) {
  Index n = find_nodeset(mesh, name);
  if (n < 0) {
    n = static_cast<Index>(mesh.nodesets.size());
    mesh.nodesets.push_back({name, id == 0 ? n + 1 : id, {}});
  }
  auto& all = mesh.nodesets[n].nodes;
  all.insert(all.end(), nodes.begin(), nodes.end());
  sort_uniquely(all);
}

}  // namespace cbr
