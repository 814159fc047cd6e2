// SPDX-License-Identifier: GPL-3.0-or-later
// L D L^T by supernodes, for its signs alone.
#pragma once

#include <optional>

#include "common/linalg/sparse/fronts.hpp"

namespace cbr {

// Number of negative pivots of P A P^T = L D L^T without pivoting (the order is the tree's, D
// diagonal); -1 when a pivot is below `vanishing` times |A_jj|. Multifrontal (Duff, Reid 1983,
// doi 10.1145/356044.356047): dense products throughout, and L is not kept. Nothing when A has an
// entry where the tree's factor has none. Subtrees in parallel; the figure and the work do not
// depend on the number of threads.
std::optional<Index> count_negative_pivots(const SupernodeTree& tree, const ShiftedMatrix& A,
                                           double vanishing, const Progress& progress = {});

}  // namespace cbr
