// SPDX-License-Identifier: GPL-3.0-or-later
#include <lapacke.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <optional>
#include <utility>

#include "common/base/threads.hpp"
#include "common/base/types.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/linalg/lower_updates.hpp"

namespace cbr {
namespace {

// Rows up to which BLAS has one thread. Most of the work is products of a matrix with a vector,
// which gain little from threads that wait for each other. 2481 rows beside three other programs: 8
// s instead of 1.5 s. Our threads divide the rest.
constexpr Index one_thread_is_enough = 4000;
// Reflections that are applied together, and columns that one thread takes at a time.
constexpr Index together = 64, slice = 128;

// BLAS while so many rows are worked at, `flops` in all.
struct BlasForRows {
  BlasForRows(Index n, double flops) {
    if (n <= one_thread_is_enough) {
      one.emplace();
    } else {
      many.emplace(flops);
    }
  }
  std::optional<SingleThreadedBlas> one;
  std::optional<LargeBlasWork> many;
};

struct Tridiagonal {
  Vector d, e, tau;  // diagonal, subdiagonal (n, the last one is workspace), reflectors
};

// All pairs by divide and conquer; Z n x n. Why not the first few by dstemr:
// docs/decisions/dense-eigenpairs.md.
bool divide_and_conquer(Tridiagonal T, Vector& lambda, Matrix& Z) {
  const Index n = T.d.size();
  Z.resize(n, n);
  const auto info =
      LAPACKE_dstedc(LAPACK_COL_MAJOR, 'I', as_int(n), T.d.data(), T.e.data(), Z.data(), as_int(n));
  lambda = T.d;
  return info == 0;
}

// Phi <- Q Phi   (n x k): block after block of reflections I - V T V^T. V is in A, whose triangle
// above the subdiagonal is overwritten. Each of our threads transforms some columns.
void apply_reflectors(Matrix& A, const Tridiagonal& T, Matrix& Phi) {
  const Index n = Phi.rows(), k = Phi.cols(), blocks = (n - 1 + together - 1) / together;
  Matrix factors = Matrix::Zero(together, blocks * together);
  for (Index b = 0; b < blocks; ++b) {
    const Index first = b * together, count = std::min(together, n - 1 - first);
    for (Index i = first; i < first + count; ++i) {
      A.col(i).segment(first, i - first + 1).setZero();
      A(i + 1, i) = 1;
    }
    LAPACKE_dlarft_work(LAPACK_COL_MAJOR, 'F', 'C', as_int(n - 1 - first), as_int(count),
                        &A(first + 1, first), as_int(n), &T.tau(first), &factors(0, b * together),
                        as_int(together));
  }
  std::atomic<Index> next{0};
  const SingleThreadedBlas blas;
  run_kept_threads(k > slice ? n_threads() : 1, [&](int) {
    Matrix VX;
    for (Index c = next++ * slice; c < k; c = next++ * slice) {
      auto X = Phi.middleCols(c, std::min(slice, k - c));
      for (Index b = blocks; b-- > 0;) {
        const Index first = b * together, count = std::min(together, n - 1 - first);
        const auto V = A.block(first + 1, first, n - 1 - first, count);
        VX.noalias() = V.transpose() * X.bottomRows(n - 1 - first);
        VX = factors.block(0, b * together, count, count).triangularView<Eigen::Upper>() * VX;
        X.bottomRows(n - 1 - first).noalias() -= V * VX;
      }
    }
  });
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
  bool ok = LAPACKE_dsytrd(LAPACK_COL_MAJOR, 'L', as_int(n), A.data(), as_int(n), T.d.data(),
                           T.e.data(), T.tau.data()) == 0;
  ok = ok && divide_and_conquer(T, pairs.lambda, pairs.Phi);
  if (ok && k < n) {
    pairs.lambda.conservativeResize(k);
    pairs.Phi.conservativeResize(Eigen::NoChange, k);
  }
  if (ok) apply_reflectors(A, T, pairs.Phi);
  if (!ok) {
    pairs.converged = false;
    pairs.n_converged = 0;
  }
  return pairs;
}

// H = I - Y T Y^T, orthogonal, whose first r columns span those of Q (n x r): Householder's, in the
// compact form of Schreiber and Van Loan (1989, doi 10.1137/0910005).
struct Reflectors {
  Matrix Y, T;  // n x r, r x r upper

  explicit Reflectors(const Matrix& Q) {
    const Index r = Q.cols();
    Reflections reflections = householder_reflections(Q);
    Y = std::move(reflections.packed);
    Y.triangularView<Eigen::StrictlyUpper>().setZero();
    Y.diagonal().setOnes();
    T = Matrix::Zero(r, r);
    for (Index j = 0; j < r; ++j) {
      T(j, j) = reflections.tau(j);
      T.col(j).head(j) =
          -T(j, j) * (T.topLeftCorner(j, j) * (Y.leftCols(j).transpose() * Y.col(j)));
    }
  }

  // A <- H^T A H, lower triangle: A - W Y^T - Y W^T, W = A Y T - 1/2 Y T^T (Y^T A Y) T   (n x r)
  void transform(Matrix& A) const {
    const Matrix A_YT = A.selfadjointView<Eigen::Lower>() * (Y * T);
    const Matrix W = A_YT - 0.5 * Y * (T.transpose() * (Y.transpose() * A_YT));
    Matrix left(Y.rows(), 2 * Y.cols()), right = left;
    left << W, Y;
    right << Y, W;
    A.triangularView<Eigen::Lower>() -= left * right.transpose();
  }

  void apply(Matrix& X) const {
    const Matrix TYX = T * (Y.transpose() * X);
    X.noalias() -= Y * TYX;
  }
};

double cube(Index n) {
  return static_cast<double>(n) * static_cast<double>(n) * static_cast<double>(n);
}
double flops_of_cholesky(Index n) { return cube(n) / 3; }
// reduction to three diagonals, and all vectors back
double flops_of_eigenpairs(Index n) { return 9 * cube(n); }

// B = L L^T, A <- L^-1 A L^-T   (lower triangles, n x n)
bool make_standard(Matrix& A, Matrix& B) {
  const Index n = A.rows();
  if (!dense_cholesky(B)) return false;
  if (n >= worth_tiles) {
    const SingleThreadedBlas blas;
    divide_both_sides(B, A);
    return true;
  }
  return LAPACKE_dsygst(LAPACK_COL_MAJOR, 1, 'L', as_int(n), A.data(), as_int(n), B.data(),
                        as_int(n)) == 0;
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
  const BlasForRows blas(n, flops_of_eigenpairs(n));
  if (n > 0) {
    // B = L L^T, A <- L^-1 A L^-T   (n x n)
    if (!make_standard(A, B)) return failed();
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
  const BlasForRows blas(A.rows(), flops_of_eigenpairs(A.rows()));
  Eigenpairs pairs = standard_eigenpairs(A, k);
  if (pairs.converged) fix_signs(pairs.Phi);
  return pairs;
}

Eigenpairs dense_eigenpairs(Matrix A, const Vector& B, Index k) {
  const Index n = A.rows();
  assert(A.cols() == n && B.size() == n && k >= 0 && k <= n);
  if (n > 0 && !(B.minCoeff() > 0)) return failed();
  const BlasForRows blas(n, flops_of_eigenpairs(n));
  const Vector scale = B.cwiseSqrt().cwiseInverse();
  // A <- B^-1/2 A B^-1/2   (n x n)
  for (Index j = 0; j < n; ++j) A.col(j).array() *= scale.array() * scale(j);
  Eigenpairs pairs = standard_eigenpairs(A, k);
  if (!pairs.converged) return pairs;
  pairs.Phi.array().colwise() *= scale.array();
  fix_signs(pairs.Phi);
  return pairs;
}

Eigenpairs dense_eigenpairs_beside(Matrix A, const Matrix& Q, std::optional<Index> count) {
  const Index n = A.rows(), r = Q.cols();
  assert(A.cols() == n && Q.rows() == n && r <= n);
  if (r == 0) return dense_eigenpairs(std::move(A), count.value_or(n));
  const BlasForRows blas(n, flops_of_eigenpairs(n));
  const Reflectors H(Q);
  H.transform(A);
  // Rows and columns 0 .. r - 1 are 0 but for round-off. They become a block of their own that the
  // solver cannot mix with the rest, below all other eigenvalues.
  double largest = 0;
  for (Index j = 0; j < n; ++j)
    largest = std::max(largest, A.col(j).tail(n - j).cwiseAbs().maxCoeff());
  A.leftCols(r).setZero();
  // in A's own unit
  A.diagonal().head(r).setConstant(largest > 0 ? -2 * static_cast<double>(n) * largest : -1);
  Eigenpairs pairs = standard_eigenpairs(A, count.value_or(n));
  if (!pairs.converged) return pairs;
  H.apply(pairs.Phi);
  pairs.lambda.head(r).setZero();
  pairs.Phi.leftCols(r) = Q;
  fix_signs(pairs.Phi);
  return pairs;
}

Eigenpairs dense_eigenpairs_beside(Matrix A, Matrix B, const Matrix& R,
                                   std::optional<Index> count) {
  const Index n = A.rows();
  assert(A.cols() == n && B.rows() == n && B.cols() == n && R.rows() == n && R.cols() <= n);
  if (n == 0 || R.cols() == 0)
    return dense_eigenpairs(std::move(A), std::move(B), count.value_or(n));
  const BlasForRows blas(n, flops_of_eigenpairs(n));
  if (!make_standard(A, B)) return failed();
  auto L = B.triangularView<Eigen::Lower>();
  // Q: orthonormal basis of L^T R   (n x r)
  const Matrix Q = orthonormal_basis(L.transpose() * R);
  Eigenpairs pairs = dense_eigenpairs_beside(std::move(A), Q, count);
  if (!pairs.converged) return pairs;
  L.transpose().solveInPlace(pairs.Phi);
  fix_signs(pairs.Phi);
  return pairs;
}

bool dense_cholesky(Matrix& A) {
  const SingleThreadedBlas blas;
  return cholesky_in_place(A);
}

void dense_inverse_of_cholesky(Matrix& L) {
  const Index n = L.rows();
  if (n == 0) return;
  const LargeBlasWork blas(2 * flops_of_cholesky(n));
  const auto info = LAPACKE_dpotri(LAPACK_COL_MAJOR, 'L', as_int(n), L.data(), as_int(n));
  assert(info == 0);
  static_cast<void>(info);
  mirror_lower(L);
}

}  // namespace cbr
