// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <limits>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/linalg/kernels/symmetric_product.hpp"
#include "common/linalg/lower_updates.hpp"

namespace cbr::dense_products_test {
namespace {

TEST(BlasKernels, OnlyAFallbackIsBettered) {
  EXPECT_EQ(better_kernels("Prescott", true, true), "SkylakeX");
  EXPECT_EQ(better_kernels("Prescott", true, false), "Haswell");
  EXPECT_EQ(better_kernels("Prescott", false, false), "");  // a processor of 2004
  for (const char* known : {"Haswell", "Zen", "SkylakeX", "Sandybridge", "armv8", ""})
    EXPECT_EQ(better_kernels(known, true, true), "");
}

TEST(SymmetricProduct, AnswersAsTheWholeMatrixDoesAndReadsTheLowerTriangle) {
  std::srand(3);
  for (const Index n : {0, 1, 3, 4, 7, 8, 13, 511, 512, 515, 1100}) {
    const Matrix A = Matrix::Random(n, n), S = A + A.transpose();
    Matrix lower = S;
    lower.triangularView<Eigen::StrictlyUpper>().setConstant(
        std::numeric_limits<double>::quiet_NaN());
    for (const Index m : {0, 1, 2, 3, 4, 6}) {
      const Matrix X = Matrix::Random(n, m), Y0 = Matrix::Random(n, m), expected = Y0 + S * X;
      Matrix Y = Y0;
      add_symmetric_product(lower, X, Y);
      EXPECT_LE((Y - expected).cwiseAbs().sum(),
                1e-14 * static_cast<double>(n) * (1 + expected.cwiseAbs().sum()))
          << n << " x " << m;
      Matrix threads = Y0;
      add_symmetric_product(lower, X, threads, 2);
      EXPECT_EQ(Y, threads);
    }
  }
}

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
}  // namespace cbr::dense_products_test
