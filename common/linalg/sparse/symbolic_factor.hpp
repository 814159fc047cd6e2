// SPDX-License-Identifier: GPL-3.0-or-later
// The order of elimination of a sparse symmetric matrix and the pattern of its factor, by CHOLMOD
// (Chen, Davis, Hager, Rajamanickam 2008, doi 10.1145/1391989.1391995). The only code that includes
// cholmod.h is symbolic_factor.cpp.
#pragma once

#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/sparse/supernodal.hpp"

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

// The arrays of a SupernodalFactor (n_super + 1 entries each, `rows` as many as pi says), without
// values.
struct SupernodePattern {
  std::vector<Index> super, pi, px, rows;
};

// Splits supernodes of more than `widest` columns into pieces of nearly the same width. A supernode
// is a rectangle with an unused half of its diagonal block: for wide separators of solids a third
// more memory. Each piece is a supernode that begins with its own rows of the shared list. The
// factor of the pattern is the same. `boundary`: a column at which a supernode begins, whatever its
// width.
SupernodePattern cut_supernodes(const SupernodalFactor& factor, Index widest, Index boundary = 0);

// The supernodes of the first n columns alone, where one ends there: without px, as their values
// stay where they are.
SupernodePattern leading_pattern(const SupernodalFactor& factor, Index n);

struct SymbolicFactor {
  std::vector<Index> order;          // n: the row that is eliminated as the i-th
  SupernodePattern pattern;          // supernodes of our width, that of `last` begins one
  double n_nonzeros = 0, flops = 0;  // of L and of its factorisation

  double bytes() const { return 8 * static_cast<double>(pattern.px.back()); }
  // With the numbers of L, or the pattern alone.
  SupernodalFactor view(const double* x = nullptr) const;
};

// Of the lower triangle of A (n x n, compressed), in the cheapest order of its graph of nodes, or
// of rows. `last`, `nodes`: as of SparseCholesky. RunError when memory does not suffice.
SymbolicFactor symbolic_factor(const SparseMatrix& A, const std::vector<Index>& last = {},
                               std::vector<Index> nodes = {});

// The cheapest order of a graph (lower triangle with its diagonal), and the rows of each column of
// its factor, in that order.
struct GraphOrder {
  std::vector<Index> order, counts;
};
GraphOrder order_of_graph(const SparseMatrix& graph);

// RunError: not enough memory for a phase ("factorisation") of n dofs. bytes: of the factor.
[[noreturn]] void fail_for_memory(const char* phase, Index n, double bytes);

}  // namespace cbr
