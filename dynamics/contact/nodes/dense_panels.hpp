// SPDX-License-Identifier: GPL-3.0-or-later
// Products with one or two vectors, by panels of columns, bounded by memory bandwidth. Not by BLAS,
// whose threads wait actively between small calls.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Y += S(:, columns) X(columns, :): X and Y (n x 1 or n x 2), S n x n. Large products use up to
// `threads` threads on separate rows, so that sums do not depend on their number.
void add_columns(const Matrix& S, const std::vector<Index>& columns, const Matrix& X, Matrix& Y,
                 int threads);

// A row of a matrix, and its factor.
struct RowWeight {
  Index row = 0;
  double weight = 0;
};

// y[i - begin] += sum of S(i, row) weight over `rows`, begin <= i < end. For many sums of the same
// columns: with some hundred rows at once these stay in the cache.
void add_weighted(const Matrix& S, const std::vector<RowWeight>& rows, Index begin, Index end,
                  double* y);
constexpr Index weighted_at_once = 128;

// S x, from the lower triangle of a symmetric S: half the memory traffic.
Vector symmetric_product(const Matrix& S, const Vector& x);

}  // namespace cbr
