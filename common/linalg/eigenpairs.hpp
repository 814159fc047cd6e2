// SPDX-License-Identifier: GPL-3.0-or-later
// Lowest eigenpairs of K x = lambda M x, sparse and dense. The only code that includes ARPACK is sparse_eigenpairs.cpp.
#pragma once

#include <string>

#include "common/linalg/sparse_cholesky.hpp"
#include "common/types.hpp"

namespace cbr {

struct Eigenpairs {
  Vector lambda;   // k, ascending
  Matrix Phi;      // n x k, Phi^T M Phi = I, sign fixed by the largest entry so that runs agree
  bool converged = false;
  Index n_converged = 0;
  Index iterations = 0;       // restarts
  std::string method;         // "arpack", "lapack", ... for the summary
};

// Shift-invert Lanczos (ARPACK dsaupd, mode 3) about sigma with `factor` = Cholesky of K - sigma M (sigma <= 0 for a
// semi-definite K). A fixed starting vector: the same input gives the same bytes.
Eigenpairs sparse_eigenpairs(const SparseMatrix& K, const SparseMatrix& M, const SparseCholesky& factor, double sigma, Index k,
                             double tolerance = 1e-13);

// LAPACK on the dense generalised problem: first k pairs (k = n: all). A and B are overwritten.
Eigenpairs dense_eigenpairs(Matrix A, Matrix B, Index k);

// Largest eigenvalue of M^-1 K with diagonal M (n), from above by a safe margin of its residual: the critical step of
// central differences is 2 / sqrt of it.
double largest_eigenvalue(const SparseMatrix& K, const Vector& M);

}  // namespace cbr
