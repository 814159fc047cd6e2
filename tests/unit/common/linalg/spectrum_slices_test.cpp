// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/eigen/spectrum_slices.hpp"

#include <gtest/gtest.h>

#include "common/linalg/sparse/signed_factor.hpp"
#include "tests/unit/common/linalg/grid_matrices.hpp"

namespace cbr::test::spectrum_slices_test {
namespace {

double largest_entry(const Matrix& A) { return A.cwiseAbs().maxCoeff(); }

TEST(SpectrumSlices, AgreeWithTheClosedForm) {
  // A cube, where nearly every eigenvalue is threefold or sixfold: cuts must not part its copies.
  // 13 is prime, so that no others are equal by chance.
  const Index N = 12, k = 300;
  const SparseMatrix K = grid_stiffness(N, true), M = diagonal_matrix(Vector::Ones(K.rows()));
  const Vector exact = grid_eigenvalues(N, true);
  const SparseCholesky factor(K);
  for (const Index width : {40, 70}) {
    const Eigenpairs pairs = eigenpairs_by_slices(K, M, factor, k, width, 1e-13, {});
    ASSERT_TRUE(pairs.converged) << width;
    EXPECT_GT(pairs.iterations, 2);
    EXPECT_LT(largest_entry(pairs.lambda - exact.head(k)), 3e-13);
    EXPECT_LT(largest_entry(pairs.Phi.transpose() * pairs.Phi - Matrix::Identity(k, k)), 4e-12);
    EXPECT_LT(largest_entry(K * pairs.Phi - pairs.Phi * pairs.lambda.asDiagonal()), 1.4e-12);
  }
}

TEST(SpectrumSlices, AgreeWithTheDenseSolver) {
  const Index N = 12, k = 260;
  const SparseMatrix K = grid_stiffness(N, true), M = grid_mass(N);
  const Eigenpairs dense = dense_eigenpairs(Matrix(K), Matrix(M), k);
  const Eigenpairs pairs = eigenpairs_by_slices(K, M, SparseCholesky(K), k, 60, 1e-13, {});
  ASSERT_TRUE(pairs.converged);
  EXPECT_LT(largest_entry((pairs.lambda - dense.lambda).cwiseQuotient(dense.lambda)), 1.8e-13);
}

TEST(SpectrumSlices, GoOnFromPairsThatAreKnown) {
  const Index N = 12, have = 80, k = 220;
  const SparseMatrix K = grid_stiffness(N, true), M = diagonal_matrix(Vector::Ones(K.rows()));
  const Vector exact = grid_eigenvalues(N, true);
  const SparseCholesky factor(K);
  const Eigenpairs known = sparse_eigenpairs(K, M, factor, 0, have);
  const Eigenpairs pairs = sparse_eigenpairs_onwards(K, M, factor, known, k);
  ASSERT_TRUE(pairs.converged);
  EXPECT_LT(largest_entry(pairs.lambda - exact.head(k)), 3e-14);
  // Vectors of neighbouring slices overlap by their residual over the gap: 1e-13 with SkylakeX
  EXPECT_LT(largest_entry(pairs.Phi.transpose() * pairs.Phi - Matrix::Identity(k, k)), 1e-12);
  EXPECT_LT(largest_entry(K * pairs.Phi - pairs.Phi * pairs.lambda.asDiagonal()), 8e-13);
  // What is known is not found again, which would give other vectors of multiple eigenvalues
  EXPECT_LT(largest_entry(pairs.Phi.leftCols(60) - known.Phi.leftCols(60)), 2e-15);
}

TEST(SpectrumSlices, TheSameInputGivesTheSameBytes) {
  const SparseMatrix K = grid_stiffness(12, true), M = grid_mass(12);
  const SparseCholesky factor(K);
  const Eigenpairs a = eigenpairs_by_slices(K, M, factor, 200, 60, 1e-13, {}),
                   b = eigenpairs_by_slices(K, M, factor, 200, 60, 1e-13, {});
  EXPECT_EQ(a.lambda, b.lambda);
  EXPECT_EQ(a.Phi, b.Phi);
}

TEST(SpectrumSlices, SharesOfProgressNeverFall) {
  const SparseMatrix K = grid_stiffness(12, true), M = grid_mass(12);
  double last = 0;
  Index told = 0;
  const Progress progress = [&](double share) {
    EXPECT_GE(share, last - 1e-12);
    EXPECT_LE(share, 1 + 1e-12);
    last = share;
    ++told;
  };
  EXPECT_TRUE(eigenpairs_by_slices(K, M, SparseCholesky(K), 200, 60, 1e-13, progress).converged);
  EXPECT_GT(told, 20);
}

TEST(SignedFactor, SolvesAndCountsInsideTheSpectrum) {
  const Index N = 12;
  const SparseMatrix K = grid_stiffness(N, true), M = grid_mass(N);
  const Vector lambda = dense_eigenpairs(Matrix(K), Matrix(M), 800).lambda;
  const SparseCholesky like(K);
  const Matrix B = Matrix::Random(K.rows(), 11);
  for (const Index j : {1, 30, 200, 350, 700}) {
    ASSERT_GT(lambda(j), lambda(j - 1) + 1e-9) << j;
    const double sigma = 0.5 * (lambda(j) + lambda(j - 1));
    SignedFactor factor(K, sigma, M, like);
    ASSERT_TRUE(factor.ok()) << j;
    EXPECT_EQ(factor.n_negative(), j);
    Matrix X = B;
    factor.solve_in_place(X);
    const Matrix residual = K * X - sigma * (M * X) - B;
    EXPECT_LT(residual.norm(), 4e-15 * K.norm() * X.norm()) << j;
  }
}

TEST(SignedFactor, RefusesAShiftThatLeavesNoPivot) {
  // All of the diagonal is zero
  const SparseMatrix K = grid_stiffness(6, true), I = diagonal_matrix(Vector::Ones(K.rows()));
  const SparseCholesky like(K);
  EXPECT_FALSE(SignedFactor(K, K.coeff(0, 0), I, like).ok());
}

}  // namespace
}  // namespace cbr::test::spectrum_slices_test
