// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of K and M that one process has: its nodes', by PT-Scotch on the graph of elements' nodes.
// It assembles them from the elements around these nodes.
#pragma once

#include <vector>

#include "common/fem/assembly.hpp"
#include "common/mesh/mesh.hpp"

namespace cbr {

// Of the interior's nodes, numbered as in Partition::interior_nodes. Each process's are numbered
// together, in the order of the whole.
struct NodeShares {
  std::vector<int> owner;     // per node its process
  std::vector<Index> number;  // per node its number in the order of the processes
  std::vector<Index> first;   // per process its first number; one more: of all
};

// node: per node of the mesh its place in the interior, or -1. To be called in all processes.
NodeShares share_nodes(const Mesh& mesh, const std::vector<Index>& node, Index n_interior);

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
