// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of a supernode's triangular solves with eight right-hand sides. X^T is narrow::width x n,
// in the order of elimination. Columns and rows are counted from the supernode's first. For the
// .cpp of this folder.
#pragma once

#include "common/linalg/sparse/supernodal.hpp"

namespace cbr::narrow {

// X <- L_bb^-1 X of the columns begin ... end, and X <- L_bb^-T X. work: as many columns of X^T.
void solve_columns(const SupernodeTree& tree, Index s, Index begin, Index end, double* X_t,
                   double* work);
void solve_columns_transposed(const SupernodeTree& tree, Index s, Index begin, Index end,
                              double* X_t, double* work);

// X_rows <- X_rows - L X_columns. work: as many columns of X^T as there are rows.
void subtract_rows(const SupernodalFactor& factor, Index s, Index begin, Index end, Index first_row,
                   Index last_row, double* X_t, double* work);
// X_columns <- X_columns - L^T X_rows
void subtract_rows_transposed(const SupernodalFactor& factor, Index s, Index begin, Index end,
                              Index first_row, Index last_row, double* X_t, double* work);

}  // namespace cbr::narrow
