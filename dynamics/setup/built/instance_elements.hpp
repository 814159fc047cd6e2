// SPDX-License-Identifier: GPL-3.0-or-later
// Extents and elements of an instance of any kind, and the motion of its nodes from the body's
// coordinates.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"
#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Box around its nodes. A superelement has interface nodes only, so that a box with its mass and
// inertia is added. Scene axes, initial position.
Box extents(const Body& body, const BuiltScene::OfInstance& instance);

// Properties, by name, of the blocks that a superelement with recovery data, or its domains,
// recover. InputError: a superelement file alone without its materials.
std::map<std::string, BlockProperties> recovered_properties(const Component& component,
                                                            const Scene& scene,
                                                            const BuiltScene::OfInstance& of);

// Nodes of the elements: those of the body, then the interior ones of each part of a superelement
// with recovery data, and rotations there. Component axes.
class InstanceElements {
 public:
  struct Group {
    std::string name;  // of the block
    Index block_id = 0;
    ElementType type = ElementType::hex8;
    BlockProperties properties;
    IndexTable nodes;                // e x n, of this instance's nodes
    std::vector<Index> element_ids;  // e, of the mesh
    // Of shells, which have a group for either face: 1 the top, along the normals, -1 the bottom
    Index face = 0;
    IndexTable rotations = {};           // e x n, of this instance's nodes
    std::vector<Matrix> of_motion = {};  // e, 6 x 6 n: stress of the face
    Index material = 0;                  // equal for blocks of equal materials, and of one face
  };

  // `of` must outlive this object. InputError: a superelement without recovery data, at `source`; a
  // superelement file alone without its materials.
  InstanceElements(const Scene& scene, const BuiltScene::OfInstance& of, const SourceLine& source);

  const std::vector<Group>& groups() const { return groups_; }
  Index n_nodes() const { return X_.rows(); }
  Index n_elements() const;
  Index n_materials() const { return n_materials_; }
  Index node_id(Index node) const { return ids_[node]; }
  Vector3 position(Index node) const { return X_.row(node).transpose(); }  // undeformed
  // Node `local` of [interface; interior] of a part.
  Index node_of_part(std::size_t part, Index local) const;
  // Nodes of a set of the mesh, the body's or recovered ones, ascending; empty: no set of this
  // name.
  std::vector<Index> nodes_of_set(const std::string& name) const;
  std::vector<std::string> set_names() const;

  // N x 3 from the body's coordinates (Body::coordinates).
  Points displacements(const Vector& q) const;
  // Rows of the nodes' displacements in terms of the body's coordinates, 3 m x n_q: row 3 i + d is
  // component d of node i.
  Matrix dense_rows(const std::vector<Index>& nodes) const;
  Index n_coordinates() const { return n_modal_ + 3 * n_body_; }
  // Whether all nodes are the body's, whose dofs are coordinates.
  bool is_mesh() const { return of_.mesh != nullptr; }
  Index dof(Index body_node) const { return n_modal_ + 3 * body_node; }

  // Nodes whose motion strains the element: its own, then their rotations.
  std::vector<Index> moving_nodes(const Group& group, Index e) const;
  // xx yy zz xy yz xz for a motion of moving_nodes(), component axes: at the centre (1 x 6), and at
  // the nodes (n x 6), which of a shell is that of the centre.
  Matrix centre_stress(const Group& group, Index e, const Points& motion) const;
  Matrix corner_stress(const Group& group, Index e, const Points& motion) const;
  // At the centres of a group's elements, and of all by group; e x 6.
  Matrix element_stresses(const Group& group, const Points& u) const;
  Matrix element_stresses(const Points& u) const;
  // A place for each node and each of its materials; its stress is the mean over elements of that
  // material.
  struct NodalPlace {
    Index node = 0, material = 0;
    Index block_id = 0;  // lowest of the blocks of that material at the node
    Index face = 0;      // of a shell
  };
  const std::vector<NodalPlace>& nodal_places() const { return places_; }
  Matrix nodal_stresses(const Points& u) const;  // nodal_places() x 6
  // Index of the place of a node and a material, or -1.
  Index place(Index node, Index material) const { return place_(node, material); }

 private:
  void add_nodes();
  void add_mesh();
  void add_parts(const Scene& scene);
  void add_group(Group group, const Block& block, const std::map<Index, Index>& rotations);
  Points element_points(const Group& group, Index e) const;  // n x 3, undeformed
  void find_materials();
  void find_places();

  const BuiltScene::OfInstance& of_;
  Index n_modal_ = 0, n_body_ = 0, n_materials_ = 0;
  std::vector<Index> first_interior_;  // of each part
  std::vector<Index> ids_;
  Points X_;
  std::vector<Group> groups_;
  std::vector<NodalPlace> places_;
  IndexTable place_;  // nodes x materials
  Vector shares_;     // per place: 1 / number of elements
};

}  // namespace cbr
