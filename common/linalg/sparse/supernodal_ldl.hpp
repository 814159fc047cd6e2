// SPDX-License-Identifier: GPL-3.0-or-later
// P A P^T = L D L^T by supernodes, D diagonal. The order is the tree's; within a front, where a
// pivot would be small, larger ones of its neighbours come first.
// Multifrontal (Duff, Reid 1983, doi 10.1145/356044.356047): dense products throughout, subtrees in
// parallel. The figures and the work do not depend on the number of threads.
#pragma once

#include <optional>
#include <vector>

#include "common/linalg/sparse/fronts.hpp"

namespace cbr {

// Number of negative pivots; -1 when a pivot is below `vanishing` times |A_jj|. L is not kept.
// Nothing when A has an entry where the tree's factor has none.
std::optional<Index> count_negative_pivots(const SupernodeTree& tree, const ShiftedMatrix& A,
                                           double vanishing, const Progress& progress = {});

struct SignedPivots {
  Vector signs;              // of D, in the order of elimination   (n)
  std::vector<Index> order;  // the column of the tree that each pivot was, of the same front   (n)
  std::vector<Index> front_end;  // after the columns of its front, for each supernode
};

// The same, and L |D|^1/2 is kept, column by column of each supernode from x[px[s]] on.
std::optional<Index> factor_with_signs(const SupernodeTree& tree, const ShiftedMatrix& A,
                                       double vanishing, const Index* px, double* x,
                                       SignedPivots& pivots);

}  // namespace cbr
