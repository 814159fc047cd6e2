// SPDX-License-Identifier: GPL-3.0-or-later
// What one process has of a component: its nodes' rows of K and M, assembled from the elements
// around them.
#pragma once

#include <vector>

#include "common/fem/assembly.hpp"
#include "reducer/distributed/node_shares.hpp"

namespace cbr {

// Square, symmetric, distributed by rows: compressed rows, columns ascending, numbered over all
// processes.
struct DistributedRows {
  std::vector<int> start, column;
  std::vector<double> value;
};

struct InteriorRows {
  // dofs of the interior, of this process, and the number of its first
  Index n = 0, n_own = 0, first = 0;
  std::vector<Index> nodes;  // of this process, in the interior's order
  DistributedRows K_II, M_II;
  SparseMatrix K_IC, M_IC;  // n_own x c
  // as rigid_residual(), of the stiffness of the elements around the own nodes
  double rigid_residual = 0;
  // c x c in the first process, 0 in the others, so that sums over processes are right
  SparseMatrix K_CC, M_CC;
};

// node, place: per node of the mesh its place in the interior and among the nodes of the interface,
// or -1. InputErrors: assemble()'s, of this process's elements.
InteriorRows assemble_rows(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                           MassKind mass, const std::vector<Index>& node,
                           const std::vector<Index>& place, Index n_interface_nodes,
                           const NodeShares& shares, int rank);

}  // namespace cbr
