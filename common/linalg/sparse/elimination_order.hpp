// SPDX-License-Identifier: GPL-3.0-or-later
// Orders of elimination found on the graph of nodes, of which each has several dofs: nine times
// fewer entries than the matrix.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// 3: the entries of A (n x n) are blocks of 3 x 3, as displacements of nodes make them. Else 1.
Index dofs_per_node(const SparseMatrix& A);

// Pattern (lower triangle with its diagonal, values 1) of the nodes of A that are not in `last`.
// last: rows of A, ascending, whole nodes.
SparseMatrix node_graph(const SparseMatrix& A, Index dofs, const std::vector<Index>& last);

// Rows of A in their order of elimination: node_graph()'s nodes in the order given, and `last`
// after them   (n)
std::vector<Index> order_of_rows(const std::vector<Index>& nodes, Index dofs, Index n,
                                 const std::vector<Index>& last);

}  // namespace cbr
