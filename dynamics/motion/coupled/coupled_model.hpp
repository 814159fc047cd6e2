// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/motion/coupled: models whose parts share nodes, by central differences or
// Newmark.
//
// A linear system whose parts share nodes: the domains of a decomposed component, a superelement
// without its diagonal form, a mesh, and shells on any of them. Sparse by dense blocks: nothing of
// the size of the whole is dense.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/fem/assembly.hpp"
#include "common/fem/shell_model.hpp"
#include "common/superelement/superelement.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"

namespace cbr {

// A superelement's dense blocks on some of the nodal dofs, and modal coordinates of its own. Its
// matrices must have been read.
struct CoupledPart {
  std::shared_ptr<const Superelement> superelement;
  std::vector<Index> dof;  // c: nodal dofs 3 node + component of the model
};

// Coordinates [q_k of part 0; q_k of part 1; ...; nodal dofs]. Nodes 0 .. n - 1 are what others
// see; n .. n + n_rotations - 1 hold the rotations of shell nodes, three dofs each. Component axes.
struct CoupledModel {
  Points coordinates;  // n x 3
  Index n_rotations = 0;
  std::vector<CoupledPart> parts;
  // N x N, N = 3 (n + n_rotations), both triangles: of meshes and shells, beyond the parts'; 0 x 0:
  // none
  SparseMatrix K, M;
  std::vector<Index> turning;  // of the n nodes those of rotations: of points, and of shells
  RigidBody rigid_body;

  Index n_nodal() const { return 3 * (coordinates.rows() + n_rotations); }
  Index n_modal() const;
  Index n() const { return n_modal() + n_nodal(); }
};

// Nodes are those of the superelement, or of the mesh's model.
CoupledModel coupled_model(std::shared_ptr<const Superelement> superelement);
CoupledModel coupled_model(const FiniteElementModel& model, const Points& coordinates);
// Superelements that share nodes: coordinates (n x 3) of the joined nodes, place[d][i] the row of
// node i of domain d there.
CoupledModel coupled_model(const std::vector<std::shared_ptr<const Superelement>>& domains,
                           const Points& coordinates, const std::vector<std::vector<Index>>& place,
                           const RigidBody& body);

// Shells whose nodes index the model's; their rotations become pseudo-nodes. mass, centre and
// inertia of rigid_body take them in.
void add_shells(const ShellModel& shells, CoupledModel& model);

// Rigid motions about the centre of mass, n x 6: [0; R_c; rotations]. Zero in nodal dofs that no
// matrix knows.
Matrix rigid_motions(const CoupledModel& model);

// What the held directions (nodes of the model), and dofs that no matrix knows, leave free: nodal
// dofs = Z y.
struct FreeDofs {
  SparseMatrix Z;       // n_nodal x free, orthonormal columns
  bool is_all = false;  // Z = I
};
FreeDofs free_dofs(const CoupledModel& model, const std::vector<HeldDirection>& held);

// K V = M V diag(omega^2), V^T M V = I of the model with held directions (nodes of the model),
// dense: for `exact`, and as an oracle. V has the rows of the coordinates. Without held directions
// the rigid modes are exact rigid motions, as those of free_modal_form(). RunError when M is not
// positive definite, named by `where`.
ModalForm modal_form(const CoupledModel& model, const std::vector<HeldDirection>& held,
                     const std::string& where);

// Nodes, coordinates and rigid body as a superelement without matrices: what ModalBody takes
// beside modal_form(). k = n_modal and c = 3 n, so that rows of nodes are those of V, whose last
// rows may be rotations. Not for a nodal enforcement, which asks for M_cc and M_kc.
Superelement nodes_only(const CoupledModel& model);

}  // namespace cbr
