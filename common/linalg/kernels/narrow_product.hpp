// SPDX-License-Identifier: GPL-3.0-or-later
// Products of a dense block with a panel of eight columns: what bounds them is reading the block,
// once, which BLAS packs first.
#pragma once

#include "common/base/types.hpp"

namespace cbr::narrow {

constexpr Index width = 8;

// Y^T = X^T L^T and X^T -= Y^T L: L rows x columns (stride apart), X^T 8 x columns, Y^T 8 x rows,
// both contiguous.
void multiply(const double* L, Index stride, Index rows, Index columns, const double* X_t,
              double* Y_t);
void subtract_transposed(const double* L, Index stride, Index rows, Index columns,
                         const double* Y_t, double* X_t);
// Y^T = X^T M of `count` columns of M from `first` on, X^T 8 x rows of M.
void multiply_columns(const SparseMatrix& M, Index first, Index count, const double* X_t,
                      double* Y_t);

}  // namespace cbr::narrow
