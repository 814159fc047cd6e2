// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement from the reduced matrices of another code (cbr-reduce --import).
#pragma once

#include <string>

#include "common/mesh/mesh.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {

// Basis craig-bampton, without sets. Nodes in the order in which rows name them first, the dofs of
// a node x, y, z; modes in the order of the rows. Mass, centre and inertia are those of the
// interface's rigid motions in M_cc, which condenses the interior's mass. InputError at `where`: K
// couples modes with the interface or with each other, M has other modal masses than 1 (1e-6 of the
// diagonals), K or M is not symmetric; a mode of eigenvalue 0 or less; an interface dof without
// stiffness or mass; rigid motions that the nodes do not determine, or that K resists. `doubts`:
// possible errors, a sentence each.
Superelement superelement_of(const ReducedMatrices& reduced, const std::string& where,
                             std::vector<std::string>& doubts);

// Gives rows their nodes' positions in the mesh. A node that the mesh does not have, and that has
// one row, is a modal coordinate. InputError: one that has several.
void place_rows(const Mesh& mesh, const std::string& mesh_file, const std::string& where,
                ReducedMatrices& reduced);

// Adds the mesh's sets whose nodes are all interface nodes. If no sideset is, each such nodeset
// becomes a surface: the outer sides of solid elements with all nodes in it. InputError naming
// `mesh_file`: an interface node that the mesh does not have, or has at another place (1e-6 of the
// mesh's size); no set and no side within the interface.
void add_faces(const Mesh& mesh, const std::string& mesh_file, const std::string& where,
               Superelement& superelement);

}  // namespace cbr
