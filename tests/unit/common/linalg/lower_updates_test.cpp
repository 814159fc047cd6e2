// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/lower_updates.hpp"

#include <gtest/gtest.h>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr::lower_updates_test {
namespace {

// Positive definite, with eigenvalues of about n / 3 and above.
Matrix definite(Index n) {
  std::srand(1);
  const Matrix R = Matrix::Random(n, n);
  Matrix A = R * R.transpose();
  A.diagonal().array() += static_cast<double>(n) / 3;
  return A;
}

double difference(const Matrix& A, const Matrix& B) {
  return (A - B).cwiseAbs().maxCoeff() / B.cwiseAbs().maxCoeff();
}

// Rows that are no whole number of tiles; more rows than columns; and a square.
TEST(LowerUpdates, ColumnsAreFactoredAsLapackFactorsThem) {
  constexpr Index n = 700;
  const Matrix A = definite(n);
  const Matrix L = Cholesky(A).lower();
  for (const Index columns : {Index{300}, n}) {
    Matrix F = A.leftCols(columns);
    {
      const SingleThreadedBlas blas;
      ASSERT_TRUE(factor_columns(F));
    }
    for (Index j = 0; j < columns; ++j) {
      EXPECT_TRUE(F.col(j).head(j) == A.col(j).head(j)) << "above the diagonal";
      F.col(j).head(j).setZero();
    }
    EXPECT_LT(difference(F, L.leftCols(columns)), 1e-13);
  }
}

TEST(LowerUpdates, WhatIsNotDefiniteIsTold) {
  Matrix A = definite(600);
  A(500, 500) = -1;
  const SingleThreadedBlas blas;
  EXPECT_FALSE(factor_columns(A));
}

TEST(LowerUpdates, BothSidesAreDividedAsByTwoDivisions) {
  constexpr Index n = 700;
  const Cholesky L(definite(n));
  const Matrix R = Matrix::Random(n, n), S = R + R.transpose();
  Matrix whole = S, half = S;
  L.solve_lower_in_place(whole);
  L.divide_by_upper(whole);
  L.divide_both_sides(half);
  for (Index j = 0; j < n; ++j)
    EXPECT_TRUE(half.col(j).head(j) == S.col(j).head(j)) << "above the diagonal";
  mirror_lower(half);
  EXPECT_LT(difference(half, whole), 1e-12);
}

// Large enough for tiles and several slices of columns.
TEST(LowerUpdates, EigenpairsOfALargePencilSolveIt) {
  constexpr Index n = 1100, k = 400;
  const Matrix M = definite(n), R = Matrix::Random(n, n), K = R + R.transpose();
  const Eigenpairs pairs = dense_eigenpairs(K, M, k);
  ASSERT_TRUE(pairs.converged);
  const Matrix M_Phi = M * pairs.Phi;
  EXPECT_LT((pairs.Phi.transpose() * M_Phi - Matrix::Identity(k, k)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(difference(K * pairs.Phi, M_Phi * pairs.lambda.asDiagonal()), 1e-11);
  for (Index j = 1; j < k; ++j) EXPECT_LE(pairs.lambda(j - 1), pairs.lambda(j));
}

}  // namespace
}  // namespace cbr::lower_updates_test
