// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/linalg/eigen: eigenpairs of dense and sparse pencils.
//
// K x = lambda M x, sparse and dense. The only code that includes ARPACK is sparse_eigenpairs.cpp.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"

namespace cbr {

struct Eigenpairs {
  Vector lambda;  // k, ascending
  Matrix Phi;     // n x k, Phi^T M Phi = I, sign fixed by the largest entry so that runs agree
  bool converged = false;
  Index n_converged = 0;
  Index iterations = 0;  // restarts, or slices
  std::string method{};  // "arpack", "lapack", ... for the summary
};

// The k eigenvalues nearest to sigma, all of them above it. Shift-invert Lanczos about sigma with
// `factor` = Cholesky of K - sigma M (sigma <= 0 for a semi-definite K). M symmetric positive
// definite. ARPACK finds a few modes (dsaupd, mode 3: Lehoucq, Sorensen, Yang 1998, doi
// 10.1137/1.9780898719628). block_lanczos finds more by products of matrices, and slices of the
// spectrum hundreds (spectrum_slices.hpp). A fixed start: the same input gives the same bytes.
// Copies of an eigenvalue may be missing where its multiplicity is beyond the Krylov space (many
// identical parts): negative_inertia() excludes that. The dense solver serves where neither can (k
// > n / 2, tiny n). `ncv`: size of ARPACK's Krylov space and choice of ARPACK for any k; 0:
// automatic. `tolerance`: relative residual that is enough for the vectors where block_lanczos
// finds them from one shift. Phi^T K Phi is diagonal then too, and eigenvalues are right to its
// square.
Eigenpairs sparse_eigenpairs(const SparseMatrix& K, const SparseMatrix& M,
                             const SparseCholesky& factor, double sigma, Index k,
                             double tolerance = 1e-13, Index ncv = 0,
                             const Progress& progress = {});

// The k lowest pairs M-orthogonal to the eigenvectors Phi (n x m, Phi^T M Phi = I). block_lanczos
// about 0 with `factor` = Cholesky of K, so that no pair is computed twice. converged: false where
// block_lanczos fails.
Eigenpairs sparse_eigenpairs_beyond(const SparseMatrix& M, const SparseCholesky& factor,
                                    const Matrix& Phi, Index k, double tolerance = 1e-13,
                                    const Progress& progress = {});

// The k lowest, of which `known` are the lowest, in slices of the spectrum about shifts of their
// own. converged is false where that does not pay, does not fit the machine, or gives up.
Eigenpairs sparse_eigenpairs_onwards(const SparseMatrix& K, const SparseMatrix& M,
                                     const SparseCholesky& factor, const Eigenpairs& known, Index k,
                                     double tolerance = 1e-13, const Progress& progress = {});

// LAPACK on the dense generalised problem A x = lambda B x (n x n, symmetric, B positive definite):
// the first k pairs (k = n: all). Reads lower triangles; overwrites A and B. converged: false when
// B is not positive definite or LAPACK failed.
Eigenpairs dense_eigenpairs(Matrix A, Matrix B, Index k);
// The same with B = I, and with diagonal B (n, > 0), by scaling.
Eigenpairs dense_eigenpairs(Matrix A, Index k);
Eigenpairs dense_eigenpairs(Matrix A, const Vector& B, Index k);

// All pairs, or the lowest `count` (from r on), of a problem with given null vectors. The first r
// have lambda = 0 exactly and span the null space. The others are orthogonal to it to round-off (in
// B's product), even if lambda is within A's round-off. Q (n x r, orthonormal): of A.
Eigenpairs dense_eigenpairs_beside(Matrix A, const Matrix& Q, std::optional<Index> count = {});
// R (n x r, independent columns): of A x = lambda B x.
Eigenpairs dense_eigenpairs_beside(Matrix A, Matrix B, const Matrix& R,
                                   std::optional<Index> count = {});

// Columns of Phi get the sign that makes the first of their largest entries positive.
void fix_signs(Matrix& Phi);

// y = A x, n-vectors.
using LinearMap = std::function<void(const Vector& x, Vector& y)>;
// Largest eigenvalue of M^-1 K, symmetric K and positive definite M (n x n). Lanczos in the inner
// product of M; its residual makes it an upper bound (Parlett 1980, 13-2). The critical step of
// central differences is 2 / sqrt of it. solve_M: y = M^-1 x. In a constrained problem x has the
// free coordinates alone, or both maps drop the constrained ones. Components in the null space of
// both maps grow from product to product (twice the right answer, of a mesh of few nodes).
double largest_eigenvalue(Index n, const LinearMap& multiply_K, const LinearMap& solve_M);

struct RitzValue {
  double value = 0, residual = 0;
};
// Largest eigenvalue of the tridiagonal matrix of n Lanczos steps (diagonal alpha, beside it beta_0
// .. beta_n-2), and the residual of its Ritz vector, |beta_n-1 s_n-1| (Parlett 1980, 13-2). In any
// unit. NaN where entries are not finite.
RitzValue largest_ritz_value(const Vector& alpha, const Vector& beta, Index n);

}  // namespace cbr
