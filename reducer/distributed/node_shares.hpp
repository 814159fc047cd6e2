// SPDX-License-Identifier: GPL-3.0-or-later
// Which process has which nodes of the interior, by PT-Scotch on the graph of elements' nodes.
#pragma once

#include <vector>

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

}  // namespace cbr
