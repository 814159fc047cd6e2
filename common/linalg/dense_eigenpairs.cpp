// SPDX-License-Identifier: GPL-3.0-or-later
#include <lapacke.h>

#include <cassert>

#include "common/linalg/dense_factor.hpp"
#include "common/linalg/eigenpairs.hpp"

namespace cbr {
namespace {

struct Tridiagonal {
  Vector d, e, tau;  // diagonal, subdiagonal (n, the last one is workspace), reflectors
};

lapack_int as_int(Index n) { return static_cast<lapack_int>(n); }

// All pairs by divide and conquer; Z n x n. Why not the first few by dstemr: docs/decisions/dense-eigenpairs.md.
bool divide_and_conquer(Tridiagonal T, Vector& lambda, Matrix& Z) {
  const Index n = T.d.size();
  Z.resize(n, n);
  const auto info = LAPACKE_dstedc(LAPACK_COL_MAJOR, 'I', as_int(n), T.d.data(), T.e.data(), Z.data(), as_int(n));
  lambda = T.d;
  return info == 0;
}

// A = Q T Q^T, the first k pairs of T, Z <- Q Z. A: lower triangle, overwritten.
Eigenpairs standard_eigenpairs(Matrix& A, Index k) {
  const Index n = A.rows();
  Eigenpairs pairs;
  pairs.method = "lapack";
  pairs.converged = true;
  pairs.n_converged = k;
  pairs.lambda.resize(k);
  pairs.Phi.resize(n, k);
  if (k == 0) return pairs;
  Tridiagonal T{Vector(n), Vector::Zero(n), Vector::Zero(n)};
  bool ok = LAPACKE_dsytrd(LAPACK_COL_MAJOR, 'L', as_int(n), A.data(), as_int(n), T.d.data(), T.e.data(), T.tau.data()) == 0;
  ok = ok && divide_and_conquer(T, pairs.lambda, pairs.Phi);
  if (ok && k < n) {
    pairs.lambda.conservativeResize(k);
    pairs.Phi.conservativeResize(Eigen::NoChange, k);
  }
  ok = ok && LAPACKE_dormtr(LAPACK_COL_MAJOR, 'L', 'L', 'N', as_int(n), as_int(k), A.data(), as_int(n), T.tau.data(),
                            pairs.Phi.data(), as_int(n)) == 0;
  if (!ok) pairs.converged = false, pairs.n_converged = 0;
  return pairs;
}

Eigenpairs failed() {
  Eigenpairs pairs;
  pairs.method = "lapack";
  return pairs;
}

}  // namespace

Eigenpairs dense_eigenpairs(Matrix A, Matrix B, Index k) {
  const Index n = A.rows();
  assert(A.cols() == n && B.rows() == n && B.cols() == n && k >= 0 && k <= n);
  if (n > 0) {
    // B = L L^T, A <- L^-1 A L^-T   (n x n)
    if (LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'L', as_int(n), B.data(), as_int(n)) != 0) return failed();
    if (LAPACKE_dsygst(LAPACK_COL_MAJOR, 1, 'L', as_int(n), A.data(), as_int(n), B.data(), as_int(n)) != 0) return failed();
  }
  Eigenpairs pairs = standard_eigenpairs(A, k);
  if (!pairs.converged) return pairs;
  // Phi = L^-T Z   (n x k)
  if (pairs.Phi.size() > 0) B.triangularView<Eigen::Lower>().transpose().solveInPlace(pairs.Phi);
  fix_signs(pairs.Phi);
  return pairs;
}

Eigenpairs dense_eigenpairs(Matrix A, Index k) {
  assert(A.cols() == A.rows() && k >= 0 && k <= A.rows());
  Eigenpairs pairs = standard_eigenpairs(A, k);
  if (pairs.converged) fix_signs(pairs.Phi);
  return pairs;
}

Eigenpairs dense_eigenpairs(Matrix A, const Vector& B, Index k) {
  const Index n = A.rows();
  assert(A.cols() == n && B.size() == n && k >= 0 && k <= n);
  if (n > 0 && !(B.minCoeff() > 0)) return failed();
  const Vector scale = B.cwiseSqrt().cwiseInverse();
  // A <- B^-1/2 A B^-1/2   (n x n)
  for (Index j = 0; j < n; ++j) A.col(j).array() *= scale.array() * scale(j);
  Eigenpairs pairs = standard_eigenpairs(A, k);
  if (!pairs.converged) return pairs;
  pairs.Phi.array().colwise() *= scale.array();
  fix_signs(pairs.Phi);
  return pairs;
}

bool dense_cholesky(Matrix& A) {
  const Index n = A.rows();
  return n == 0 || LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'L', as_int(n), A.data(), as_int(n)) == 0;
}

void dense_inverse_of_cholesky(Matrix& L) {
  const Index n = L.rows();
  if (n == 0) return;
  const auto info = LAPACKE_dpotri(LAPACK_COL_MAJOR, 'L', as_int(n), L.data(), as_int(n));
  assert(info == 0);
  static_cast<void>(info);
  mirror_lower(L);
}

}  // namespace cbr
