// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/partition: interior and interface, and the sets that a superelement keeps.
//
// Interior and interface: which dofs are kept, and the blocks of K and M that follow.
#pragma once

#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/base/types.hpp"
#include "common/fem/assembly.hpp"
#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"
#include "reducer/partition/rigid_motions.hpp"

namespace cbr {

// I: interior, C: interface; both in the order of the model's nodes, each node's x, y, z together.
struct Partition {
  // model nodes (rows of FiniteElementModel::nodes), ascending
  std::vector<Index> interior_nodes, interface_nodes;
  // Of each dof its row of the model's K, and where dofs are fixed 3 i + c of its node i.
  std::vector<Index> interior_rows, interface_rows, interior_dofs, interface_dofs;
  SparseMatrix K_II, K_IC, K_CC;  // n_I x n_I, n_I x c, c x c
  SparseMatrix M_II, M_IC, M_CC;
  bool lumped = false;  // M is diagonal, but for points: M_IC = 0
  // The last 2 n_points of the interface's nodes are those of points: x, y, z of each one's
  // translation, then of its rotation (rigid_points.hpp). Set before the partition.
  Index n_points = 0;
  // The last so many of either list are rotations of nodes of shells; none beside points.
  Index interior_rotations = 0, interface_rotations = 0;
  RigidMotions rigid;  // exact in the condensation; none unless set

  // True if the dofs of the interface's node i are a rotation.
  bool is_rotation(Index i) const {
    const Index first = static_cast<Index>(interface_nodes.size()) - 2 * n_points;
    if (n_points == 0) return i >= first - interface_rotations;
    return i >= first && (i - first) % 2 == 1;
  }
  // Those of the interior's node i
  bool is_interior_rotation(Index i) const {
    return i >= static_cast<Index>(interior_nodes.size()) - interior_rotations;
  }
  Index interior_dof(Index row) const { return interior_dofs.empty() ? row : interior_dofs[row]; }
  Index interface_dof(Index row) const {
    return interface_dofs.empty() ? row : interface_dofs[row];
  }
  bool has_fixed() const { return !interior_dofs.empty() || !interface_dofs.empty(); }
  bool has_rotations() const { return n_points + interior_rotations + interface_rotations > 0; }
  Index n_interior() const { return K_II.rows(); }
  Index n_interface() const { return K_CC.rows(); }
};

// The nodes that solids and shells use, as assemble() numbers them, without K and M: for questions
// of connectivity. InputError: there are none.
FiniteElementModel number_nodes(const Mesh& mesh);

// The model nodes of the named sidesets and nodesets, ascending and unique. InputError: a name that
// the mesh does not have, a set without nodes or with a node that no volume element uses, no name
// at all.
std::vector<Index> interface_nodes(const Mesh& mesh, const FiniteElementModel& model,
                                   const std::vector<std::string>& sets);

// Those of reduction.interface, which has no set where there are points.
std::vector<Index> nodes_of_sets(const Mesh& mesh, const FiniteElementModel& model,
                                 const ReductionOptions& reduction);

// Nodes of the model that are not among these, which ascend.
std::vector<Index> other_nodes(const FiniteElementModel& model, const std::vector<Index>& nodes);

Partition partition(const FiniteElementModel& model, const std::vector<Index>& interface_nodes);
// The same into one that exists, as Eigen 3.4 would copy its matrices.
void partition(const FiniteElementModel& model, const std::vector<Index>& interface_nodes,
               Partition& p);

// K_II is singular where a part's interior can move as a rigid body against its interface nodes.
// InputError naming the part by a node id, the missing constraint (no interface node; fewer than
// three that are not on one line) and the cure.
void check_interface_holds(const Mesh& mesh, const FiniteElementModel& model,
                           const Partition& partition, const std::vector<Index>& parts);

// "node id 28 of block 'flap'": how messages name a node of the mesh (an index).
std::string name_of_node(const Mesh& mesh, Index node);
std::string name_of_node_id(const Mesh& mesh, Index id);

// A component of several parts says so, and warns where their nodes meet without being joined.
// `parts`: of connected_parts().
void tell_of_parts(const Mesh& mesh, const FiniteElementModel& model,
                   const std::vector<Index>& parts, Report& report);

// Dofs (n_I or c) of a list of model nodes.
std::vector<Index> dofs_of(const std::vector<Index>& nodes);

// Takes the rows of fixed dofs out of the model's K and M. InputError at an entry: no such set, a
// node that no volume element uses.
void fix_dofs(const Mesh& mesh, const std::vector<FixedSet>& fixed, FiniteElementModel& model);

}  // namespace cbr
