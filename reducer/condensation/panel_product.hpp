// SPDX-License-Identifier: GPL-3.0-or-later
// Panels of right-hand sides, stored by rows, times the blocks of a partition; rows and columns in
// another order.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Flops of a solve cost as much as this many of a product (docs/decisions/reduction.md).
constexpr double solve_penalty = 1.5;

// A x X, sparse or, where A is a sum of dense blocks as that of joined domains, dense.
Matrix product(const SparseMatrix& A, const Eigen::Ref<const Matrix>& X);

// X^T A for a fixed A (n x m) and transposed panels X^T (w x n), by columns of A.
class PanelProduct {
 public:
  explicit PanelProduct(SparseMatrix A);

  const SparseMatrix& sparse() const { return sparse_; }
  // out += alpha X^T A, of A the last out.cols() columns   (w x out.cols())
  void add(const Eigen::Ref<const Matrix>& X_t, double alpha, Eigen::Ref<Matrix> out) const;

 private:
  SparseMatrix sparse_;
  Matrix dense_;
};

// place[order[i]] = i   (n)
std::vector<Index> inverse(const std::vector<Index>& order);

// B(place[i], j) = A(i, order[j])
SparseMatrix reordered(const SparseMatrix& A, const std::vector<Index>& place,
                       const std::vector<Index>& order);

// Rows in which `count` columns of A from the first on have entries, ascending.
std::vector<Index> rows_of(const SparseMatrix& A, Index first, Index count);

// Columns of K_IC by the first of their rows to be eliminated: neighbours in this order reach much
// the same supernodes.
std::vector<Index> by_first_row(const SparseMatrix& K_IC, const std::vector<Index>& place);

// From the upper triangle of B, which is in this order, both triangles of A in its own, A(order[i],
// order[j]) = B(i, j), in the same memory; A exactly symmetric.
void restore_order(const std::vector<Index>& order, Matrix& B);

}  // namespace cbr
