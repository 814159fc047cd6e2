// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/sparse_cholesky.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "tests/unit/common/linalg/grid_matrices.hpp"

namespace cbr::test::sparse_cholesky_test {
namespace {

double residual(const SparseMatrix& A, const Matrix& X, const Matrix& B) {
  return (A * X - B).norm() / B.norm();
}

TEST(SparseCholesky, SolvesOneAndManyRightHandSides) {
  const SparseMatrix A = grid_stiffness(9, true);
  const SparseCholesky factor(A);
  ASSERT_TRUE(factor.ok());
  EXPECT_GE(factor.n_nonzeros(), static_cast<double>(A.nonZeros()) / 2);
  EXPECT_GT(factor.flops(), factor.n_nonzeros());
  // More columns than one block of right-hand sides, and not a multiple of it.
  const Matrix B = random_like(A.rows(), 301, 0.3);
  const Matrix X = factor.solve(B);
  EXPECT_LT(residual(A, X, B), 1e-13);

  Vector x(A.rows());
  for (const Index j : {Index{0}, Index{300}, Index{7}}) {
    factor.solve(B.col(j).data(), x.data());
    EXPECT_LT((x - X.col(j)).norm(), 1e-13 * x.norm());
  }
  x = B.col(2);
  factor.solve(x.data(), x.data());
  EXPECT_LT((x - X.col(2)).norm(), 1e-13 * x.norm());
}

TEST(SparseCholesky, SolvesInPlaceInABlockOfALargerMatrix) {
  const SparseMatrix A = grid_stiffness(5, true);
  const SparseCholesky factor(A);
  const Matrix B = random_like(A.rows() + 4, 150, 1.0);
  Matrix X = B;
  factor.solve_in_place(X.middleRows(3, A.rows()));
  EXPECT_LT(residual(A, X.middleRows(3, A.rows()), B.middleRows(3, A.rows())), 1e-13);
  EXPECT_EQ(X.topRows(3), B.topRows(3));
  EXPECT_EQ(X.bottomRows(1), B.bottomRows(1));
}

TEST(SparseCholesky, FewRightHandSidesAtATime) {
  const SparseMatrix A = grid_stiffness(8, true);
  const SparseCholesky factor(A);
  for (const Index columns : {1, 2, 3, 7, 8, 9, 15, 16, 17, 40, 132}) {
    const Matrix B = random_like(A.rows(), columns, 0.4);
    EXPECT_LT(residual(A, factor.solve(B), B), 1e-13) << columns;
  }
}

// D + u u^T, dense: one supernode of all columns.
TEST(SparseCholesky, WideSupernodesAreCutIntoPieces) {
  constexpr Index n = 1300;
  const Vector D = Vector::LinSpaced(n, 1, 2), u = random_like(n, 1, 0.7).col(0).normalized();
  const auto shifted = [&](double sigma) {
    Matrix A = u * u.transpose();
    A.diagonal() += D - Vector::Constant(n, sigma);
    return SparseMatrix(A.sparseView());
  };
  const SparseMatrix A = shifted(0);
  const SparseCholesky factor(A);
  EXPECT_EQ(factor.n_nonzeros(), 0.5 * n * (n + 1));
  EXPECT_LT(factor.bytes(), 0.8 * 8 * n * n);
  EXPECT_GE(factor.bytes(), 8 * factor.n_nonzeros());
  for (const Index columns : {1, 5, 60}) {
    const Matrix B = random_like(n, columns, 0.2);
    EXPECT_LT(residual(A, factor.solve(B), B), 1e-13) << columns;
  }
  for (const double sigma : {0.5, 1.2345, 1.8765, 2.5}) {
    // By the inertia of [D - sigma, u; u^T, -1], eliminated from either end
    const Vector d = D.array() - sigma;
    const Index expected =
        (d.array() < 0).count() + (1 + u.cwiseAbs2().cwiseQuotient(d).sum() > 0 ? 1 : 0) - 1;
    EXPECT_EQ(negative_inertia(shifted(sigma)), expected);
    EXPECT_EQ(negative_inertia(shifted(sigma), &factor), expected);
  }
}

TEST(SparseCholesky, ReadsTheLowerTriangleOnly) {
  SparseMatrix A = grid_stiffness(4, true);
  const SparseMatrix lower = A.triangularView<Eigen::Lower>();
  const Matrix B = random_like(A.rows(), 2, 0.1);
  EXPECT_LT(residual(A, SparseCholesky(lower).solve(B), B), 1e-13);
}

TEST(SparseCholesky, SameMatrixSameBits) {
  const SparseMatrix A = grid_stiffness(8, true);
  const Matrix B = random_like(A.rows(), 40, 0.7);
  EXPECT_EQ(SparseCholesky(A).solve(B), SparseCholesky(A).solve(B));
}

TEST(SparseCholesky, LargeFactorisationsTellHowFarTheyAre) {
  std::vector<double> told;
  const SparseCholesky factor(grid_stiffness(22, true), {},
                              [&](double share) { told.push_back(share); });
  ASSERT_TRUE(factor.ok());
  ASSERT_GT(factor.flops(), 2e8);  // so large that it goes front by front
  ASSERT_GT(told.size(), 2u);
  EXPECT_GT(told.front(), 0);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_NEAR(told.back(), 1, 1e-12);
}

TEST(SparseCholesky, NamesTheColumnOfAnIndefiniteMatrix) {
  SparseMatrix A = grid_stiffness(6, true);
  for (const Index j : {Index{0}, Index{100}, Index{215}}) {
    SparseMatrix bad = A;
    bad.coeffRef(j, j) = -1;
    const SparseCholesky factor(bad);
    EXPECT_FALSE(factor.ok());
    EXPECT_EQ(factor.weakest_column(), j);
    EXPECT_EQ(factor.smallest_pivot(), 0);
  }
}

TEST(SparseCholesky, TellsASingularMatrixByItsPivots) {
  // Round-off may let a singular matrix pass as definite: then the weakest pivot tells.
  const SparseCholesky free(grid_stiffness(6, false));
  EXPECT_TRUE(!free.ok() || free.smallest_pivot() < 1e-13);
  const SparseCholesky clamped(grid_stiffness(6, true));
  EXPECT_GT(clamped.smallest_pivot(), 1e-2);

  // A stiff and a soft part, and units that make all entries small, are no sign of it.
  const SparseMatrix K = grid_stiffness(6, true);
  Vector scale = Vector::Constant(K.rows(), 1e-20);
  scale.head(100).setConstant(1e-14);
  const SparseMatrix scaled = scale.asDiagonal() * K * scale.asDiagonal();
  EXPECT_GT(SparseCholesky(scaled).smallest_pivot(), 1e-2);
}

// Three dofs a node, all of which meet.
SparseMatrix with_three_dofs(const SparseMatrix& K) {
  const Matrix3 coupling = (Matrix3() << 2, 0.5, 0.25, 0.5, 3, -0.5, 0.25, -0.5, 1).finished();
  Triplets entries;
  for (Index j = 0; j < K.cols(); ++j)
    for (SparseMatrix::InnerIterator it(K, j); it; ++it)
      for (Index a = 0; a < 3; ++a)
        for (Index b = 0; b < 3; ++b)
          entries.emplace_back(3 * it.row() + a, 3 * j + b, coupling(a, b) * it.value());
  SparseMatrix A(3 * K.rows(), 3 * K.cols());
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

SparseMatrix without(const SparseMatrix& A, const std::vector<Index>& rows) {
  std::vector<Index> left;
  for (Index i = 0; i < A.rows(); ++i)
    if (!std::binary_search(rows.begin(), rows.end(), i)) left.push_back(i);
  return SparseMatrix(Matrix(Matrix(A)(left, left)).sparseView());
}

TEST(SparseCholesky, FirstColumnsAreAFactorOfWhatIsNotLast) {
  for (const Index dofs : {Index{1}, Index{3}}) {
    const SparseMatrix K = grid_stiffness(7, true), A = dofs == 3 ? with_three_dofs(K) : K;
    std::vector<Index> last;  // a face, and a node far from it
    for (Index i = 0; i < A.rows(); ++i)
      if (i / dofs < 49 || i / dofs == 300) last.push_back(i);
    const SparseMatrix inner = without(A, last);
    std::optional<SparseCholesky> leading;
    {
      const SparseCholesky whole(A, last);
      ASSERT_TRUE(whole.ok());
      const Matrix B = random_like(A.rows(), 37, 0.2);
      EXPECT_LT(residual(A, whole.solve(B), B), 1e-13);
      const SupernodalFactor& f = whole.tree().factor();
      EXPECT_TRUE(std::equal(last.begin(), last.end(), f.order + inner.rows()));
      leading = whole.leading();
    }
    ASSERT_TRUE(leading->ok());
    EXPECT_EQ(leading->n_rows(), inner.rows());
    for (const Index columns : {1, 8, 37}) {
      const Matrix B = random_like(inner.rows(), columns, 0.1);
      EXPECT_LT(residual(inner, leading->solve(B), B), 1e-13) << columns;
    }
    const Vector b = random_like(inner.rows(), 1, 0.7).col(0);
    Vector x(b.size());
    leading->solve(b.data(), x.data());
    EXPECT_LT(residual(inner, x, b), 1e-13);
    const SparseCholesky own(inner);
    EXPECT_GT(leading->smallest_pivot(), 1e-3);
    EXPECT_LT(leading->n_nonzeros(), 2 * own.n_nonzeros());
    SparseMatrix I(inner.rows(), inner.rows());
    I.setIdentity();
    for (const double sigma : {0.7, 3.3})
      EXPECT_EQ(negative_inertia(inner, sigma, I, *leading), negative_inertia(inner - sigma * I));
  }
}

TEST(SparseCholesky, WhatIsNotLastMayBeFineWhereTheWholeIsNot) {
  const SparseMatrix free = grid_stiffness(6, false);
  const std::vector<Index> last{3, 100, 215};
  SparseMatrix A = free;
  A.coeffRef(100, 100) = -1;
  const SparseCholesky whole(A, last), leading = whole.leading();
  EXPECT_FALSE(whole.ok());
  EXPECT_EQ(whole.weakest_column(), 100);
  ASSERT_TRUE(leading.ok());
  const SparseMatrix inner = without(A, last);
  const Matrix B = random_like(inner.rows(), 5, 0.1);
  EXPECT_LT(residual(inner, leading.solve(B), B), 1e-12);
  // And a failure before them is the leading one's, by its own number
  A.coeffRef(50, 50) = -1;
  const SparseCholesky failed = SparseCholesky(A, last).leading();
  EXPECT_FALSE(failed.ok());
  EXPECT_EQ(failed.weakest_column(), 49);
  EXPECT_EQ(SparseCholesky(free, {}).leading().n_rows(), free.rows());
}

// Large enough for threads to share it.
TEST(SparseCholesky, IsTheSameOnAnyNumberOfThreads) {
  const SparseMatrix A = grid_stiffness(24, true);
  const Matrix B = random_like(A.rows(), 9, 0.3);
  std::optional<Matrix> before;
  for (const int threads : {1, 2, 3}) {
    set_threads(threads);
    const SparseCholesky factor(A);
    ASSERT_TRUE(factor.ok());
    ASSERT_GT(factor.flops(), 2e8);
    set_threads(1);
    const Matrix Y = factor.solve(B);
    EXPECT_LT(residual(A, Y, B), 1e-13) << threads;
    if (!before) before = Y;
    EXPECT_EQ(Y, *before) << threads << " threads";
  }
  set_threads(0);
}

TEST(SparseCholesky, FrontsNameTheColumnThatFails) {
  SparseMatrix A = grid_stiffness(24, true);
  for (const Index column : {Index{100}, Index{7500}, Index{13000}}) {
    const double before = A.coeff(column, column);
    A.coeffRef(column, column) = -before;
    const SparseCholesky factor(A);
    EXPECT_FALSE(factor.ok());
    // Its diagonal is in no pivot before it
    EXPECT_EQ(factor.weakest_column(), column);
    A.coeffRef(column, column) = before;
  }
}

// The last rows are a front of their own, which many subtrees meet.
TEST(SparseCholesky, FrontsKeepTheLastRowsLast) {
  const SparseMatrix A = grid_stiffness(22, true);
  std::vector<Index> last;
  for (Index i = 0; i < 300; ++i) last.push_back(i);
  const SparseCholesky factor(A, last), leading = factor.leading();
  ASSERT_GT(factor.flops(), 1e8);
  ASSERT_TRUE(factor.ok() && leading.ok());
  const Matrix B = random_like(A.rows(), 5, 0.3);
  EXPECT_LT(residual(A, factor.solve(B), B), 1e-13);
  const Index n = A.rows() - 300;
  const SparseMatrix inside = A.bottomRightCorner(n, n);
  const Matrix b = B.bottomRows(n);
  EXPECT_LT(residual(inside, leading.solve(b), b), 1e-13);
}

// K and M of a face and a node far from it, condensed front by front, beside dense matrices; and
// the factor of the rest.
TEST(SparseCholesky, CondensesToTheLastRows) {
  const Index N = 9;
  for (const bool consistent : {false, true}) {
    const SparseMatrix K = grid_stiffness(N, true), all = grid_mass(N),
                       M = consistent ? all : diagonal_matrix(Matrix(all).diagonal());
    std::vector<Index> last, first;
    for (Index i = 0; i < K.rows(); ++i) (i < N * N || i == 600 ? last : first).push_back(i);
    Condensed condensed;
    const auto factor = SparseCholesky::condensing(K, M, last, condensed, true);
    ASSERT_TRUE(factor && factor->ok());
    Matrix T = Matrix::Zero(K.rows(), static_cast<Index>(last.size()));
    T(last, Eigen::all).setIdentity();
    const Matrix dense = K, K_IC = dense(first, last);
    T(first, Eigen::all) = -Cholesky(Matrix(dense(first, first))).solve(K_IC);
    const Matrix K_cc = T.transpose() * (K * T), M_cc = T.transpose() * (M * T);
    EXPECT_LT((condensed.K - K_cc).norm(), 1e-14 * K_cc.norm());
    EXPECT_LT((condensed.M - M_cc).norm(), 1e-14 * M_cc.norm());
    EXPECT_EQ(condensed.M, Matrix(condensed.M.transpose()));
    EXPECT_GT(condensed.flops, 0);
    const Matrix B = random_like(factor->n_rows(), 11, 0.3);
    EXPECT_LT(residual(without(K, last), factor->solve(B), B), 1e-13);
  }
}

TEST(SparseCholesky, CondensesTheSameOnAnyNumberOfThreads) {
  const Index N = 18;
  const SparseMatrix K = grid_stiffness(N, true), M = grid_mass(N);
  std::vector<Index> last;
  for (Index i = 0; i < N * N; ++i) last.push_back(i);
  Condensed one, three;
  set_threads(1);
  ASSERT_TRUE(SparseCholesky::condensing(K, M, last, one));
  set_threads(3);
  ASSERT_TRUE(SparseCholesky::condensing(K, M, last, three));
  set_threads(0);
  EXPECT_EQ(one.K, three.K);
  EXPECT_EQ(one.M, three.M);
  // T^T K T and T^T M T of one motion, by a factor of its own
  const SparseCholesky factor(without(K, last));
  Vector x = Vector::Zero(K.rows());
  x.head(N * N).setRandom();
  x.tail(K.rows() - N * N) = factor.solve(Matrix(-(K * x).tail(K.rows() - N * N)));
  EXPECT_NEAR(x.head(N * N).dot(one.K * x.head(N * N)), x.dot(K * x), 1e-13 * x.dot(K * x));
  EXPECT_NEAR(x.head(N * N).dot(one.M * x.head(N * N)), x.dot(M * x), 1e-13 * x.dot(M * x));
}

TEST(SparseCholesky, CondensesNotWhereItCannot) {
  const Index N = 9;
  SparseMatrix K = grid_stiffness(N, true);
  Condensed condensed;
  const SparseMatrix M = grid_mass(N);
  EXPECT_FALSE(SparseCholesky::condensing(K, M, {3}, condensed)) << "too small to be worth it";
  EXPECT_FALSE(SparseCholesky::condensing(K, M, {}, condensed, true));
  SparseMatrix foreign = M;
  foreign.coeffRef(700, 0) = foreign.coeffRef(0, 700) = 0.01;
  foreign.makeCompressed();
  EXPECT_FALSE(SparseCholesky::condensing(K, foreign, {3}, condensed, true));
  K.coeffRef(100, 100) = -1;
  EXPECT_FALSE(SparseCholesky::condensing(K, M, {3}, condensed, true));
}

TEST(SparseCholesky, TinyMatrices) {
  EXPECT_TRUE(SparseCholesky(SparseMatrix(0, 0)).ok());
  EXPECT_EQ(SparseCholesky(SparseMatrix(0, 0)).solve(Matrix(0, 3)).cols(), 3);
  const SparseCholesky one(diagonal_matrix(Vector::Constant(1, 4.0)));
  EXPECT_EQ(one.solve(Matrix(Matrix::Constant(1, 1, 2.0)))(0, 0), 0.5);
  EXPECT_FALSE(SparseCholesky(diagonal_matrix(Vector::Zero(1))).ok());
}

TEST(NegativeInertia, CountsEigenvaluesBelowAShift) {
  const Index N = 7;
  const SparseMatrix K = grid_stiffness(N, true);
  const Vector lambda = grid_eigenvalues(N, true);
  SparseMatrix I(K.rows(), K.rows());
  I.setIdentity();
  EXPECT_EQ(negative_inertia(K), 0);
  EXPECT_EQ(negative_inertia(-K), K.rows());
  for (const double sigma : {0.5, 1.234, 3.21, 5.4321, 11.0}) {
    EXPECT_EQ(negative_inertia(K - sigma * I), (lambda.array() < sigma).count()) << sigma;
  }
}

TEST(NegativeInertia, TakesTheOrderOfAFactorWhereItsPatternSuffices) {
  // Large enough for fronts of several blocks of pivots and for subtrees of several threads.
  const Index N = 13;
  const SparseMatrix K = grid_stiffness(N, true);
  const Vector lambda = grid_eigenvalues(N, true);
  const SparseCholesky factor(K);
  SparseMatrix I(K.rows(), K.rows());
  I.setIdentity();
  for (const double sigma : {0.2, 1.234, 5.4321}) {
    const Index count = (lambda.array() < sigma).count();
    EXPECT_EQ(negative_inertia(K - sigma * I, &factor), count) << sigma;
    // An entry that K has not: far below the gap around sigma, so that the count is the same.
    SparseMatrix other = K - sigma * I;
    other.coeffRef(K.rows() - 1, 0) = 1e-12;
    other.coeffRef(0, K.rows() - 1) = 1e-12;
    other.makeCompressed();
    EXPECT_EQ(negative_inertia(other, &factor), count) << sigma;
  }
}

TEST(NegativeInertia, SaysWhenAPivotVanishes) {
  EXPECT_EQ(negative_inertia(diagonal_matrix(Vector::LinSpaced(5, -2, 2))), -1);
  EXPECT_EQ(negative_inertia(diagonal_matrix(Vector::Zero(3))), -1);
  EXPECT_EQ(negative_inertia(SparseMatrix(0, 0)), 0);
}

}  // namespace
}  // namespace cbr::test::sparse_cholesky_test
