// SPDX-License-Identifier: GPL-3.0-or-later
// One sparse factorisation, used for everything. The only code that includes cholmod.h is sparse_cholesky.cpp.
#pragma once

#include <memory>
#include <string>

#include "common/types.hpp"

namespace cbr {

// A = P^T L L^T P of a symmetric positive definite matrix: CHOLMOD supernodal, nested dissection (METIS).
class SparseCholesky {
 public:
  // Only the lower triangle of A is read. Not positive definite is a result, not an exception: ask ok().
  explicit SparseCholesky(const SparseMatrix& A);
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  bool ok() const;
  Index failed_column() const;     // column of A where a pivot was not positive; -1 when ok
  double reciprocal_condition() const;  // CHOLMOD's estimate from the diagonal of L
  Index n_rows() const;
  double n_nonzeros() const;       // of L
  double flops() const;            // of the factorisation

  Matrix solve(const Matrix& B) const;               // A X = B, n x m
  SparseMatrix solve(const SparseMatrix& B) const;   // exploits empty columns and rows of B
  void solve_in_place(Eigen::Ref<Matrix> B) const;
  // Workspace kept between calls: for ARPACK's many single right-hand sides.
  void solve(const double* b, double* x) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Number of negative pivots of L D L^T = A, by Sylvester the number of eigenvalues below zero; -1 when a pivot vanished.
Index negative_inertia(const SparseMatrix& A);

}  // namespace cbr
