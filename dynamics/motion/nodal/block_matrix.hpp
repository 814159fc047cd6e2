// SPDX-License-Identifier: GPL-3.0-or-later
// A sparse matrix of 3 x 3 blocks by rows: the product with a vector is what a full mesh spends its
// time on.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/threads.hpp"
#include "common/base/types.hpp"

namespace cbr {

// n x n blocks; block b of row i is values[9 b .. 9 b + 8], by columns, in column column[b]. One
// index a block, of 32 bits, instead of nine of 64: the product is bound by memory.
struct BlockMatrix {
  std::vector<std::int64_t> first;  // n + 1
  std::vector<std::int32_t> column;
  std::vector<double> values;  // and one more: four are read at a time
  Index rows() const { return static_cast<Index>(first.size()) - 1; }
};

// From dofs 3 i + c. A block is kept when any of its entries is stored.
BlockMatrix block_matrix(const SparseMatrix& A);

// y = A x, rows shared among the threads; the same bits for any number of threads.
void multiply(const BlockMatrix& A, const double* x, double* y, RowThreads& threads);
inline void multiply(const BlockMatrix& A, const Points& x, Points& y, RowThreads& threads) {
  multiply(A, x.data(), y.data(), threads);
}

// Rows begin .. end - 1 of A x added to f, component c of row i at f[c * stride + i - begin]; x by
// planes: component c of row j at x[c * x_stride + j].
void add_rows(const BlockMatrix& A, const double* x, Index x_stride, Index begin, Index end,
              double* f, Index stride);

// A symmetric matrix by the blocks on and above its diagonal: half of the bytes. Block b is
// values[9 b .. 9 b + 8], by rows; the first of each row is the diagonal one.
struct SymmetricBlockMatrix {
  std::vector<std::int64_t> first;  // n + 1
  std::vector<std::int32_t> column;
  std::vector<double> values;  // and one more: four are read at a time
  Index reach = 0;             // the most of column - row
  Index rows() const { return static_cast<Index>(first.size()) - 1; }
};

// P A P^T of a symmetric A of dofs 3 i + c, row i of the result that of node order[i].
SymmetricBlockMatrix symmetric_block_matrix(const SparseMatrix& A, const std::vector<Index>& order);

}  // namespace cbr
