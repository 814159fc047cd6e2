// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/exchange: a superelement as two matrices, which other codes want.
//
// A superelement as two symmetric matrices with a list that says what each row is: what other codes
// want.
#pragma once

#include <vector>

#include "common/superelement/superelement.hpp"

namespace cbr {

// A displacement of an interface node, or a modal coordinate.
struct ReducedRow {
  Index node = 0;  // of the mesh; of a modal coordinate a number above all of these
  int dof = 0;     // 1, 2, 3 = x, y, z; 0: a modal coordinate
  Vector3 position = Vector3::Zero();
  double eigenvalue = 0;  // (rad/s)^2, of a modal coordinate
};

// K and M, n x n, dense: interface dofs first, in the order of the file, then modal coordinates.
// Of bases characteristic and massless: modes of unit mass, then residual vectors without mass, all
// of dof 0; the interface follows them, u = T q.
struct ReducedMatrices {
  Matrix K, M;
  std::vector<ReducedRow> rows;       // n
  Matrix T;                           // c x n, or empty
  std::vector<ReducedRow> interface;  // c, rows of T
  bool has_damping = false;           // an import's files have a damping matrix, which is not read
  bool has_recovery = false;          // and recovery data of the interior
};

// Modal coordinates are nodes from `first_modal_node` on; 0: from the first above all nodes of the
// interface. InputError: a first_modal_node that is not above the interface's; compliance in
// levels.
ReducedMatrices reduced_matrices(const Superelement& s, Index first_modal_node = 0);

}  // namespace cbr
