// SPDX-License-Identifier: GPL-3.0-or-later
// L D L^T by supernodes, for its signs alone.
#pragma once

#include <optional>

#include "common/linalg/supernodal.hpp"

namespace cbr {

// K - sigma M, never formed; M null: K. Symmetric, both triangles stored.
struct ShiftedMatrix {
  const SparseMatrix& K;
  double sigma = 0;
  const SparseMatrix* M = nullptr;

  // use(row, value) for the entries of a column; one that both matrices have comes twice, in parts.
  template <typename Use>
  void each(Index column, const Use& use) const {
    for (SparseMatrix::InnerIterator it(K, column); it; ++it) use(it.row(), it.value());
    if (M == nullptr) return;
    for (SparseMatrix::InnerIterator it(*M, column); it; ++it) use(it.row(), -sigma * it.value());
  }
};

// Number of negative pivots of P A P^T = L D L^T without pivoting (the order is the tree's, D diagonal); -1 when a pivot is below
// `vanishing` times |A_jj|. Multifrontal (Duff, Reid 1983, doi 10.1145/356044.356047): dense products throughout, and L is not
// kept. Nothing when A has an entry where the tree's factor has none. Subtrees in parallel;
// the figure and the work do not depend on the number of threads.
std::optional<Index> count_negative_pivots(const SupernodeTree& tree, const ShiftedMatrix& A, double vanishing);

// Bytes that the fronts of such a count take at the most, one thread working.
double front_bytes(const SupernodeTree& tree);

}  // namespace cbr
