// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/built/instance_elements.hpp"

#include <algorithm>
#include <set>

#include "common/base/error.hpp"
#include "common/fem/elements/nodal_stress.hpp"
#include "dynamics/setup/components/superelement_alone.hpp"

namespace cbr {
namespace {

bool is_same(const Material& a, const Material& b) {
  if (a.youngs_modulus != b.youngs_modulus || a.poissons_ratio != b.poissons_ratio) return false;
  if (a.orthotropy.has_value() != b.orthotropy.has_value()) return false;
  if (!a.orthotropy) return true;
  const Orthotropy &s = *a.orthotropy, &t = *b.orthotropy;
  return s.youngs_moduli == t.youngs_moduli && s.poissons_ratios == t.poissons_ratios &&
         s.shear_moduli == t.shear_moduli && s.axes == t.axes && s.center == t.center;
}

}  // namespace

Box extents(const Body& body, const BuiltScene::OfInstance& instance) {
  const Points& x = body.reference_positions();
  Box box{x.colwise().minCoeff().transpose(), x.colwise().maxCoeff().transpose()};
  if (instance.parts.size() != 1) return box;
  const RigidBody& rigid = instance.parts.front().superelement->rigid_body;
  if (!(rigid.mass > 0)) return box;
  const Matrix3& T = instance.placement.T;
  // int x x^T dm / m = (trace(I) / 2 1 - I) / m; for a box it is a third of the squared half edge
  const Matrix3 spread = T * (0.5 * rigid.inertia.trace() * Matrix3::Identity() - rigid.inertia) *
                         T.transpose() / rigid.mass;
  const Vector3 half = (3 * spread.diagonal()).cwiseMax(0).cwiseSqrt(),
                centre = T * rigid.center + instance.placement.position;
  box.lower = box.lower.cwiseMin(centre - half);
  box.upper = box.upper.cwiseMax(centre + half);
  return box;
}

std::map<std::string, BlockProperties> recovered_properties(const Component& component,
                                                            const Scene& scene,
                                                            const BuiltScene::OfInstance& of) {
  Mesh names;  // only names and types of blocks are used; a domain may lack some
  for (const ReducedPart& part : of.parts)
    for (const Block& block : part.superelement->recovery.front().blocks)
      if (find_block(names, block.name) < 0) names.blocks.push_back(block);
  mark_shells(component, names);
  const bool in_scene =
      component.has_mesh && (!component.material.empty() || !may_hold_materials(component.mesh));
  const std::vector<BlockProperties> properties =
      in_scene
          ? block_properties(scene, component, names)
          : properties_in_file(component, of.parts.front().superelement->provenance, names.blocks);
  std::map<std::string, BlockProperties> by_name;
  for (std::size_t b = 0; b < names.blocks.size(); ++b)
    by_name[names.blocks[b].name] = properties[b];
  return by_name;
}

InstanceElements::InstanceElements(const Scene& scene, const BuiltScene::OfInstance& of,
                                   const SourceLine& source)
    : of_(of), n_modal_(of.n_modal), n_body_(of.geometry->coordinates.rows()) {
  for (const ReducedPart& part : of.parts)
    if (part.superelement->recovery.empty())
      throw InputError(
          source.text() + ": instance '" + of.name +
          "': its superelement has no recovery data, from which stress and interior points follow: "
          "give its "
          "component reduction: {recovery: true}, or recovery: [SET, ...], and run cbr-reduce");
  add_nodes();
  of.mesh ? add_mesh() : add_parts(scene);
  find_materials();
  find_places();
}

void InstanceElements::add_nodes() {
  Index n = n_body_;
  for (const ReducedPart& part : of_.parts) {
    first_interior_.push_back(n);
    const Superelement::Recovery& recovery = part.superelement->recovery.front();
    n += recovery.coordinates.rows() + static_cast<Index>(recovery.rotations.size());
  }
  ids_ = of_.geometry->node_ids;
  X_.setZero(n, 3);
  X_.topRows(n_body_) = of_.geometry->coordinates;
  for (std::size_t p = 0; p < of_.parts.size(); ++p) {
    const Superelement::Recovery& recovery = of_.parts[p].superelement->recovery.front();
    ids_.insert(ids_.end(), recovery.node_ids.begin(), recovery.node_ids.end());
    X_.middleRows(first_interior_[p], recovery.coordinates.rows()) = recovery.coordinates;
    for (const Index node : recovery.rotations) ids_.push_back(ids_[node_of_part(p, node)]);
  }
}

Index InstanceElements::node_of_part(std::size_t p, Index local) const {
  const std::vector<Index>& node = of_.parts[p].node;
  const auto n = static_cast<Index>(node.size());
  return local < n ? node[local] : first_interior_[p] + local - n;
}

// rotations: of the nodes of shells
void InstanceElements::add_group(Group group, const Block& block,
                                 const std::map<Index, Index>& rotations) {
  group.name = block.name;
  group.block_id = block.id;
  group.type = block.type;
  group.element_ids = block.element_ids;
  if (dimension(block.type) == 3) return groups_.push_back(std::move(group));
  const auto is_known = [&](Index node) { return rotations.contains(node); };
  const auto nodes = group.nodes.reshaped();
  // Recovery data before 1.16 have no rotations
  if (!is_structure(block) || !std::all_of(nodes.begin(), nodes.end(), is_known)) return;
  group.rotations = group.nodes.unaryExpr([&](Index node) { return rotations.at(node); });
  Group bottom = group;
  group.face = 1;
  bottom.face = -1;
  for (Index e = 0; e < group.nodes.rows(); ++e) {
    const Matrix faces = shell_stress(group.type, element_points(group, e),
                                      {group.properties.material, block.thickness});
    group.of_motion.emplace_back(faces.topRows(6));
    bottom.of_motion.emplace_back(faces.bottomRows(6));
  }
  groups_.push_back(std::move(group));
  groups_.push_back(std::move(bottom));
}

void InstanceElements::add_mesh() {
  for (std::size_t b = 0; b < of_.mesh->blocks.size(); ++b) {
    const Block& block = of_.mesh->blocks[b];
    if (!is_structure(block)) continue;
    Group group{.properties = of_.properties[b], .nodes = block.connectivity};
    for (Index& node : group.nodes.reshaped()) node = of_.body_node[node];
    add_group(std::move(group), block, of_.geometry->rotations);
  }
}

void InstanceElements::add_parts(const Scene& scene) {
  const Component& component = scene.components.at(of_.component);
  const std::map<std::string, BlockProperties> properties =
      recovered_properties(component, scene, of_);
  for (std::size_t p = 0; p < of_.parts.size(); ++p) {
    const Superelement::Recovery& recovery = of_.parts[p].superelement->recovery.front();
    std::map<Index, Index> rotations = of_.geometry->rotations;
    Index next = first_interior_[p] + recovery.coordinates.rows();
    for (const Index node : recovery.rotations) rotations[node_of_part(p, node)] = next++;
    for (const Block& block : recovery.blocks) {
      Group group{.properties = properties.at(block.name), .nodes = block.connectivity};
      for (Index& node : group.nodes.reshaped()) node = node_of_part(p, node);
      add_group(std::move(group), block, rotations);
    }
  }
}

void InstanceElements::find_materials() {
  std::vector<const Group*> known;
  for (Group& group : groups_) {
    const auto found = std::find_if(known.begin(), known.end(), [&](const Group* other) {
      return is_same(other->properties.material, group.properties.material) &&
             other->face == group.face;
    });
    group.material = found - known.begin();
    if (found == known.end()) known.push_back(&group);
  }
  n_materials_ = static_cast<Index>(known.size());
}

void InstanceElements::find_places() {
  place_ = IndexTable::Constant(n_nodes(), n_materials_, -1);
  std::vector<double> counts;
  for (const Group& group : groups_) {
    for (const Index node : group.nodes.reshaped()) {
      Index& place = place_(node, group.material);
      if (place < 0) {
        place = static_cast<Index>(places_.size());
        places_.push_back({node, group.material, group.block_id, group.face});
        counts.push_back(0);
      }
      Index& block = places_[place].block_id;
      block = std::min(block, group.block_id);
      counts[place] += 1;
    }
  }
  shares_ =
      Eigen::Map<const Vector>(counts.data(), static_cast<Index>(counts.size())).cwiseInverse();
}

Index InstanceElements::n_elements() const {
  Index n = 0;
  for (const Group& group : groups_) n += group.nodes.rows();
  return n;
}

std::vector<Index> InstanceElements::nodes_of_set(const std::string& name) const {
  std::vector<Index> nodes;
  const Geometry& geometry = *of_.geometry;
  if (const auto surface = geometry.surfaces.find(name); surface != geometry.surfaces.end())
    return surface_nodes(surface->second);
  if (const auto set = geometry.nodesets.find(name); set != geometry.nodesets.end())
    nodes = set->second;
  for (std::size_t p = 0; p < of_.parts.size(); ++p) {
    const auto& sets = of_.parts[p].superelement->recovered_sets;
    const auto found = sets.find(name);
    if (found == sets.end()) continue;
    for (const Index local : found->second) nodes.push_back(node_of_part(p, local));
  }
  sort_uniquely(nodes);
  return nodes;
}

std::vector<std::string> InstanceElements::set_names() const {
  std::set<std::string> names;
  for (const auto& [name, surface] : of_.geometry->surfaces) names.insert(name);
  for (const auto& [name, nodes] : of_.geometry->nodesets) names.insert(name);
  for (const ReducedPart& part : of_.parts)
    for (const auto& [name, nodes] : part.superelement->recovered_sets) names.insert(name);
  return {names.begin(), names.end()};
}

namespace {

// u_c of a part from the body's coordinates
Vector interface_motion(const ReducedPart& part, Index n_modal, const Vector& q) {
  const Superelement& s = *part.superelement;
  Vector u_c(s.c());
  for (Index i = 0; i < s.c(); ++i) {
    const auto dof = static_cast<std::size_t>(i);
    u_c[i] = q[n_modal + 3 * part.node[s.dof_node[dof]] + s.dof_component[dof] % 3];
  }
  return u_c;
}

}  // namespace

Points InstanceElements::displacements(const Vector& q) const {
  Points u(n_nodes(), 3);
  u.topRows(n_body_) = Eigen::Map<const Points>(q.data() + n_modal_, n_body_, 3);
  for (std::size_t p = 0; p < of_.parts.size(); ++p) {
    const ReducedPart& part = of_.parts[p];
    const Superelement::Recovery& recovery = part.superelement->recovery.front();
    // u_I = Psi u_c + Phi q_k
    const Vector u_I = recovery.Psi * interface_motion(part, n_modal_, q) +
                       recovery.Phi * q.segment(part.first_mode, part.superelement->k());
    u.middleRows(first_interior_[p], u_I.size() / 3) =
        Eigen::Map<const Points>(u_I.data(), u_I.size() / 3, 3);
  }
  return u;
}

Matrix InstanceElements::dense_rows(const std::vector<Index>& nodes) const {
  Matrix rows = Matrix::Zero(3 * static_cast<Index>(nodes.size()), n_coordinates());
  for (Index i = 0; i < static_cast<Index>(nodes.size()); ++i) {
    const Index node = nodes[i];
    if (node < n_body_) {
      for (int d = 0; d < 3; ++d) rows(3 * i + d, dof(node) + d) = 1;
      continue;
    }
    const auto p = static_cast<std::size_t>(
        std::upper_bound(first_interior_.begin(), first_interior_.end(), node) -
        first_interior_.begin() - 1);
    const ReducedPart& part = of_.parts[p];
    const Superelement& s = *part.superelement;
    const Superelement::Recovery& recovery = s.recovery.front();
    const Index local = 3 * (node - first_interior_[p]);
    rows.block(3 * i, part.first_mode, 3, s.k()) = recovery.Phi.middleRows(local, 3);
    for (Index c = 0; c < s.c(); ++c) {
      const auto j = static_cast<std::size_t>(c);
      const Index column = dof(part.node[s.dof_node[j]]) + s.dof_component[j] % 3;
      rows.block(3 * i, column, 3, 1) = recovery.Psi.block(local, c, 3, 1);
    }
  }
  return rows;
}

Points InstanceElements::element_points(const Group& group, Index e) const {
  return X_(group.nodes.row(e), Eigen::all);
}

std::vector<Index> InstanceElements::moving_nodes(const Group& group, Index e) const {
  const auto own = group.nodes.row(e);
  std::vector<Index> nodes(own.begin(), own.end());
  if (group.face == 0) return nodes;
  const auto rotations = group.rotations.row(e);
  nodes.insert(nodes.end(), rotations.begin(), rotations.end());
  return nodes;
}

Matrix InstanceElements::centre_stress(const Group& group, Index e, const Points& motion) const {
  if (group.face != 0)
    return (group.of_motion[e] * Eigen::Map<const Vector>(motion.data(), motion.size()))
        .transpose();
  return element_stress(group.type, group.properties.hex, element_points(group, e),
                        group.properties.material, motion)
      .transpose();
}

Matrix InstanceElements::corner_stress(const Group& group, Index e, const Points& motion) const {
  if (group.face != 0) return centre_stress(group, e, motion).replicate(group.nodes.cols(), 1);
  return element_nodal_stress(group.type, group.properties.hex, element_points(group, e),
                              group.properties.material, motion);
}

Matrix InstanceElements::element_stresses(const Group& group, const Points& u) const {
  Matrix stress(group.nodes.rows(), 6);
  for (Index e = 0; e < stress.rows(); ++e)
    stress.row(e) = centre_stress(group, e, u(moving_nodes(group, e), Eigen::all));
  return stress;
}

Matrix InstanceElements::element_stresses(const Points& u) const {
  Matrix stress(n_elements(), 6);
  Index row = 0;
  for (const Group& group : groups_) {
    stress.middleRows(row, group.nodes.rows()) = element_stresses(group, u);
    row += group.nodes.rows();
  }
  return stress;
}

Matrix InstanceElements::nodal_stresses(const Points& u) const {
  Matrix stress = Matrix::Zero(static_cast<Index>(places_.size()), 6);
  for (const Group& group : groups_) {
    for (Index e = 0; e < group.nodes.rows(); ++e) {
      const Matrix of_element = corner_stress(group, e, u(moving_nodes(group, e), Eigen::all));
      for (Index a = 0; a < of_element.rows(); ++a)
        stress.row(place_(group.nodes(e, a), group.material)) += of_element.row(a);
    }
  }
  return shares_.asDiagonal() * stress;
}

}  // namespace cbr
