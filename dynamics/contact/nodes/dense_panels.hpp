// SPDX-License-Identifier: GPL-3.0-or-later
// Products and triangular solves with one vector or two, by panels of columns, on the caller's
// thread: what bounds them is memory. Not by BLAS, whose threads wait spinning between small calls.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Y += S(:, columns) X(columns, :): X and Y (n x 1 or n x 2), S n x n. Large ones by up to
// `threads` threads, each with its own rows, so that the sums do not depend on their number.
void add_columns(const Matrix& S, const std::vector<Index>& columns, const Matrix& X, Matrix& Y,
                 int threads);

// S x, from the lower triangle of a symmetric S: half the memory to read.
Vector symmetric_product(const Matrix& S, const Vector& x);

// y = L^-1 y and y = L^-T y with the leading n x n lower triangle of L.
void solve_lower(const Matrix& L, Index n, double* y);
void solve_lower_transposed(const Matrix& L, Index n, double* y);

}  // namespace cbr
