// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/linalg/blas_threads.hpp"
#include "tests/unit/common/linalg/grid_matrices.hpp"

namespace cbr::test::eigenpairs_test {
namespace {

void expect_pairs(const Eigenpairs& pairs, const SparseMatrix& K, const SparseMatrix& M, Index k) {
  ASSERT_TRUE(pairs.converged);
  ASSERT_EQ(pairs.lambda.size(), k);
  ASSERT_EQ(pairs.Phi.cols(), k);
  if (k == 0) return;
  const Matrix M_Phi = M * pairs.Phi;
  EXPECT_LT((pairs.Phi.transpose() * M_Phi - Matrix::Identity(k, k)).cwiseAbs().maxCoeff(), 1e-12);
  // Residuals against the largest eigenvalue that can be there: the backward error of any
  // eigensolver.
  const double scale = 12 / Vector(M.diagonal()).minCoeff();
  EXPECT_LT((K * pairs.Phi - M_Phi * pairs.lambda.asDiagonal()).colwise().norm().maxCoeff(),
            1e-11 * scale);
  EXPECT_TRUE(std::is_sorted(pairs.lambda.begin(), pairs.lambda.end()));
}

SparseMatrix identity(Index n) { return diagonal_matrix(Vector::Ones(n)); }

TEST(SparseEigenpairs, FindsEveryCopyOfMultipleEigenvalues) {
  // A cube: nearly every eigenvalue is threefold or sixfold.
  const Index N = 9;
  const SparseMatrix K = grid_stiffness(N, true), M = identity(K.rows());
  const Vector exact = grid_eigenvalues(N, true);
  const SparseCholesky factor(K);
  for (const Index k : {Index{1}, Index{10}, Index{60}}) {
    const Eigenpairs pairs = sparse_eigenpairs(K, M, factor, 0, k);
    EXPECT_EQ(pairs.method, k < 10 ? "arpack" : "block lanczos");
    expect_pairs(pairs, K, M, k);
    EXPECT_LT((pairs.lambda - exact.head(k)).cwiseAbs().maxCoeff(), 1e-12);
    // No copy missed below the next eigenvalue that differs.
    Index next = k;
    while (exact(next) - exact(k - 1) < 1e-6) ++next;
    const double sigma = 0.5 * (exact(k - 1) + exact(next));
    EXPECT_EQ(negative_inertia(K - sigma * M), next);
  }
}

TEST(SparseEigenpairs, AgreesWithTheDenseSolver) {
  const Index N = 8, k = 40;
  const SparseMatrix K = grid_stiffness(N, true), M = grid_mass(N);
  const Eigenpairs sparse = sparse_eigenpairs(K, M, SparseCholesky(K), 0, k);
  const Eigenpairs dense = dense_eigenpairs(Matrix(K), Matrix(M), k);
  expect_pairs(sparse, K, M, k);
  expect_pairs(dense, K, M, k);
  EXPECT_LT(((sparse.lambda - dense.lambda).array() / dense.lambda.array()).abs().maxCoeff(),
            1e-11);
}

TEST(SparseEigenpairs, FreeBodyThroughANegativeShift) {
  const Index N = 8, k = 20;
  const SparseMatrix K = grid_stiffness(N, false), M = grid_mass(N);
  const double sigma = -0.01;
  const SparseCholesky factor(K - sigma * M);
  ASSERT_TRUE(factor.ok());
  const Eigenpairs pairs = sparse_eigenpairs(K, M, factor, sigma, k);
  expect_pairs(pairs, K, M, k);
  EXPECT_LT(std::abs(pairs.lambda(0)), 1e-12);
  EXPECT_GT(pairs.lambda(1), 1e-2);
  const Vector rigid = pairs.Phi.col(0);
  EXPECT_LT((rigid.array() - rigid.mean()).abs().maxCoeff(), 1e-11 * std::abs(rigid.mean()));
  EXPECT_LT((pairs.lambda - dense_eigenpairs(Matrix(K), Matrix(M), k).lambda).cwiseAbs().maxCoeff(),
            1e-11);
}

TEST(SparseEigenpairs, SameBitsTwice) {
  const SparseMatrix K = grid_stiffness(7, true), M = grid_mass(7);
  const SparseCholesky factor(K);
  const Eigenpairs a = sparse_eigenpairs(K, M, factor, 0, 30),
                   b = sparse_eigenpairs(K, M, factor, 0, 30);
  EXPECT_EQ(a.lambda, b.lambda);
  EXPECT_EQ(a.Phi, b.Phi);
}

TEST(SparseEigenpairs, AnInvariantSubspaceIsSurvivedAndSeenByTheInertia) {
  // Three distinct eigenvalues, 100 copies of each: every Krylov space ends after three blocks, and
  // copies beyond its reach are missed. What is returned must still be eigenpairs, and the count
  // must tell.
  Vector d(300);
  for (Index i = 0; i < 300; ++i) d(i) = 1 + static_cast<double>(i % 3);
  const SparseMatrix K = diagonal_matrix(d), M = identity(300);
  EXPECT_EQ(negative_inertia(K - 1.5 * M), 100);
  for (const Index k : {Index{1}, Index{12}, Index{60}, Index{120}}) {
    const Eigenpairs pairs = sparse_eigenpairs(K, M, SparseCholesky(K), 0, k);
    if (pairs.converged) expect_pairs(pairs, K, M, k);
  }
}

TEST(SparseEigenpairs, NoneAllAndTiny) {
  const SparseMatrix K = grid_stiffness(3, true), M = grid_mass(3);
  const SparseCholesky factor(K);
  EXPECT_EQ(sparse_eigenpairs(K, M, factor, 0, 0).Phi.cols(), 0);
  for (const Index k : {Index{1}, Index{26}, Index{27}})
    expect_pairs(sparse_eigenpairs(K, M, factor, 0, k), K, M, k);
  const SparseMatrix one = diagonal_matrix(Vector::Constant(1, 3.0));
  EXPECT_NEAR(sparse_eigenpairs(one, one, SparseCholesky(one), 0, 1).lambda(0), 1, 1e-15);
}

TEST(DenseEigenpairs, FewAndAllForFullAndDiagonalMass) {
  const Index N = 6, n = N * N * N;
  const SparseMatrix K = grid_stiffness(N, true), M = grid_mass(N),
                     D = diagonal_matrix(M.diagonal());
  for (const Index k : {Index{0}, Index{1}, Index{5}, Index{50}, Index{100}, n}) {
    expect_pairs(dense_eigenpairs(Matrix(K), Matrix(M), k), K, M, k);
    const Eigenpairs diagonal = dense_eigenpairs(Matrix(K), Vector(M.diagonal()), k);
    expect_pairs(diagonal, K, D, k);
    const Eigenpairs full = dense_eigenpairs(Matrix(K), Matrix(D), k);
    EXPECT_LT((diagonal.lambda - full.lambda).lpNorm<1>(), 1e-12 * static_cast<double>(k + 1));
  }
  const Vector exact = grid_eigenvalues(N, true);
  EXPECT_LT((dense_eigenpairs(Matrix(K), Vector(Vector::Ones(n)), n).lambda - exact)
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

// Threads that shared LAPACK's reflectors got one of ten or so wrong at this size.
TEST(DenseEigenpairs, ThreadsGetTheSameBitsEachTime) {
  const int before = n_threads();
  set_threads(2);
  Matrix A = random_like(260, 260, 0.3);
  A = (A + A.transpose()).eval();
  const Eigenpairs first = dense_eigenpairs(A, 260);
  EXPECT_LT((first.Phi.transpose() * first.Phi - Matrix::Identity(260, 260)).norm(), 1e-11);
  for (int i = 0; i < 60; ++i) {
    ASSERT_EQ(dense_eigenpairs(A, 260).Phi, first.Phi) << i;
  }
  set_threads(before);
}

TEST(DenseEigenpairs, AMassThatIsNotDefiniteIsAResult) {
  const Matrix K = Matrix::Identity(4, 4);
  Matrix B = K;
  B(2, 2) = -1;
  EXPECT_FALSE(dense_eigenpairs(K, B, 2).converged);
  EXPECT_FALSE(dense_eigenpairs(K, Vector(Vector::Zero(4)), 2).converged);
}

TEST(FixSigns, FirstOfTheLargestIsPositive) {
  Matrix Phi(3, 3);
  Phi << 1, -2, 1e-9, -2, -2 - 1e-12, -1e-9, 2, 1, 0;
  fix_signs(Phi);
  EXPECT_EQ(Phi(1, 0), 2);  // -2 came first and turned the column over
  EXPECT_EQ(Phi(0, 1), 2);  // equal but for round-off: the first one decides
  EXPECT_EQ(Phi(0, 2), 1e-9);
}

TEST(SparseEigenpairs, SlenderPartsDoNotAskForMoreThanRoundOffAllows) {
  // A beam: the lowest of 80 eigenvalues is 4e7 times below the highest, so that 1e-13 of the
  // smallest theta is below the round-off of the largest.
  const Index n = 1500, k = 80;
  Triplets entries;
  for (Index i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 2.0);
    if (i > 0) {
      entries.emplace_back(i, i - 1, -1.0);
      entries.emplace_back(i - 1, i, -1.0);
    }
  }
  SparseMatrix A(n, n), M(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  M.setIdentity();
  const SparseMatrix K = A * A;
  const Eigenpairs pairs = sparse_eigenpairs(K, M, SparseCholesky(K), 0, k);
  ASSERT_TRUE(pairs.converged);
  EXPECT_EQ(pairs.method, "block lanczos");
  EXPECT_LE(pairs.iterations, 3);
  const Eigenpairs beyond =
      sparse_eigenpairs_beyond(M, SparseCholesky(K), pairs.Phi.leftCols(k / 2), k / 2);
  ASSERT_TRUE(beyond.converged);
  EXPECT_LE(beyond.iterations, 3);
  EXPECT_LT(
      (beyond.lambda - pairs.lambda.tail(k / 2)).cwiseQuotient(beyond.lambda).cwiseAbs().maxCoeff(),
      1e-8);
  EXPECT_LT((pairs.Phi.transpose() * pairs.Phi - Matrix::Identity(k, k)).cwiseAbs().maxCoeff(),
            1e-12);
  for (Index j = 0; j < k; ++j) {
    const double root = 2 - 2 * std::cos(std::numbers::pi * static_cast<double>(j + 1) /
                                         static_cast<double>(n + 1));
    EXPECT_NEAR(pairs.lambda[j], root * root, 1e-13) << j;  // |K| = 16
  }
}

// A grid of three unlike lengths, which has no equal eigenvalues
SparseMatrix unlike_grid() {
  SparseMatrix A = grid_stiffness(14, true);
  for (Index i = 0; i < A.rows(); ++i)
    A.coeffRef(i, i) += 0.01 * static_cast<double>(i % 14) + 0.003 * static_cast<double>(i / 196);
  return A;
}

// Errors of eigenvalues are of second order in the residual. Phi^T A Phi is diagonal whatever it
// is.
TEST(SparseEigenpairs, RitzVectorsAreOfAWhereLessIsEnoughForVectors) {
  const SparseMatrix A = unlike_grid();
  SparseMatrix M(A.rows(), A.rows());
  M.setIdentity();
  const SparseCholesky factor(A);
  const Index k = 100;
  const auto worst = [&](const Eigenpairs& pairs) {
    const Matrix R = A * pairs.Phi - pairs.Phi * pairs.lambda.asDiagonal();
    return (R.colwise().norm().transpose().array() / pairs.lambda.array()).maxCoeff();
  };
  const Eigenpairs exact = sparse_eigenpairs(A, M, factor, 0, k);
  const Eigenpairs pairs = sparse_eigenpairs(A, M, factor, 0, k, 1e-3);
  ASSERT_TRUE(pairs.converged);
  EXPECT_EQ(pairs.method, "block lanczos");
  EXPECT_GT(worst(pairs), 1e4 * worst(exact));
  EXPECT_LT(worst(pairs), 1e-2);
  EXPECT_LT((pairs.lambda - exact.lambda).cwiseQuotient(exact.lambda).cwiseAbs().maxCoeff(), 1e-6);
  Matrix H = pairs.Phi.transpose() * (A * pairs.Phi);
  H.diagonal() -= pairs.lambda;
  EXPECT_LT(H.cwiseAbs().maxCoeff(), 1e-12 * pairs.lambda(k - 1));
  EXPECT_LT((pairs.Phi.transpose() * pairs.Phi - Matrix::Identity(k, k)).cwiseAbs().maxCoeff(),
            1e-12);
}

TEST(LargestEigenvalue, IsAnUpperBoundAndSharp) {
  for (const Index N : {Index{2}, Index{3}, Index{5}, Index{12}}) {
    for (const bool clamped : {true, false}) {
      const SparseMatrix K = grid_stiffness(N, clamped);
      const Vector exact = grid_eigenvalues(N, clamped);
      const double bound = largest_eigenvalue(
          K.rows(), [&](const Vector& x, Vector& y) { y.noalias() = K * x; },
          [](const Vector& x, Vector& y) { y = x / 2; });
      const double truth = exact(exact.size() - 1) / 2;
      EXPECT_GE(bound, truth * (1 - 1e-12));
      EXPECT_LE(bound, truth * (1 + 1e-6));
    }
  }
}

TEST(LargestEigenvalue, DoesNotRiseAboveASpectrumFarFromZero) {
  // A chain of unlike masses, each held by a spring of its own, with eigenvalues 1 to 1.4: where
  // the mean of a spectrum is far above its width, vectors and their products with M drift apart by
  // a power of that ratio unless one is made from the other.
  const Index n = 100;
  Matrix K = Matrix::Zero(n, n);
  Vector mass(n);
  for (Index i = 0; i < n; ++i) {
    mass[i] = 1 + 0.1 * static_cast<double>((7 * i) % 10);
    K(i, i) = mass[i];
  }
  for (Index i = 0; i + 1 < n; ++i) {
    K(i, i) += 0.1;
    K(i + 1, i + 1) += 0.1;
    K(i, i + 1) -= 0.1;
    K(i + 1, i) -= 0.1;
  }
  const Vector root = mass.cwiseSqrt().cwiseInverse();
  const Vector eigen = symmetric_eigenvalues(root.asDiagonal() * K * root.asDiagonal());
  const double truth = eigen[n - 1];
  const double bound = largest_eigenvalue(
      n, [&](const Vector& x, Vector& y) { y = K * x; },
      [&](const Vector& x, Vector& y) { y = x.cwiseQuotient(mass); });
  EXPECT_GE(bound, truth * (1 - 1e-12));
  EXPECT_LE(bound, truth * (1 + 1e-9));
}

TEST(LargestEigenvalue, CoordinatesOfVeryUnlikeMassesDoNotHideEachOther) {
  // A chain, and light oscillators on their own that are much slower: of a thousandth of the
  // frequency, of a mass of 1e-60.
  const Index n = 30;
  Matrix K = Matrix::Zero(2 * n, 2 * n);
  Vector mass = Vector::Ones(2 * n);
  for (Index i = 0; i + 1 < n; ++i) {
    K(i, i) += 1;
    K(i + 1, i + 1) += 1;
    K(i, i + 1) = K(i + 1, i) = -1;
  }
  for (Index i = n; i < 2 * n; ++i) {
    mass[i] = 1e-60;
    K(i, i) = 1e-66 * static_cast<double>(i);
  }
  const double truth =
      2 - 2 * std::cos(std::numbers::pi * static_cast<double>(n - 1) / static_cast<double>(n));
  const double bound = largest_eigenvalue(
      2 * n, [&](const Vector& x, Vector& y) { y = K * x; },
      [&](const Vector& x, Vector& y) { y = x.cwiseQuotient(mass); });
  EXPECT_GE(bound, truth * (1 - 1e-12));
  EXPECT_LE(bound, truth * (1 + 1e-6));
}

TEST(LargestRitzValue, IsTheSameInAnyUnit) {
  // Blocks that hang together by round-off, as when few distinct eigenvalues have many copies each
  const Index n = 27;
  Vector alpha(n), beta(n);
  for (Index i = 0; i < n; ++i) {
    alpha[i] = i % 3 == 0 ? 1.1 : 0.3 * static_cast<double>(1 + i % 5);
    beta[i] = i % 9 == 8 ? 2e-9 * static_cast<double>(i) : 0.05 / static_cast<double>(1 + i % 4);
  }
  Matrix T = alpha.asDiagonal();
  T.diagonal(1) = T.diagonal(-1) = beta.head(n - 1);
  const SymmetricEigen exact = symmetric_eigen(T);
  for (const double unit : {1e-300, 1e-30, 1e-3, 1.0, 1e3, 1e9, 1e17, 1e30, 1e150}) {
    const RitzValue ritz = largest_ritz_value(unit * alpha, unit * beta, n);
    EXPECT_NEAR(ritz.value / unit, exact.values[n - 1], 1e-14) << unit;
    EXPECT_NEAR(ritz.residual / unit, std::abs(beta[n - 1] * exact.vectors(n - 1, n - 1)), 1e-15)
        << unit;
  }
  EXPECT_TRUE(std::isnan(largest_ritz_value(Vector::Constant(n, NAN), beta, n).value));
}

TEST(DenseEigenpairsBeside, NullVectorsAreKeptApartFromModesBelowRoundOff) {
  // Two free chains joined by a spring 1e-14 as stiff as their own: one elastic eigenvalue is lost
  // in round-off.
  const Index n = 24;
  Matrix K = Matrix::Zero(n, n);
  const auto tie = [&](Index i, double k) {
    K(i, i) += k;
    K(i + 1, i + 1) += k;
    K(i, i + 1) -= k;
    K(i + 1, i) -= k;
  };
  for (Index i = 0; i + 1 < n; ++i) tie(i, 2 * i + 2 == n ? 1e-14 : 1);
  Matrix M = Matrix::Identity(n, n);
  for (Index i = 0; i + 1 < n; ++i) M(i, i + 1) = M(i + 1, i) = 0.2;
  M(3, 3) = 1e6;
  M(20, 20) = 1e-3;
  M(19, 20) = M(20, 19) = M(20, 21) = M(21, 20) = 1e-3;
  const Matrix R = Matrix::Ones(n, 1);
  const Eigenpairs pairs = dense_eigenpairs_beside(K, M, R);
  ASSERT_TRUE(pairs.converged);
  EXPECT_EQ(pairs.lambda(0), 0);
  EXPECT_LT((pairs.Phi.transpose() * M * pairs.Phi - Matrix::Identity(n, n)).cwiseAbs().maxCoeff(),
            1e-12);
  EXPECT_LT((pairs.Phi.col(0) - R * pairs.Phi(0, 0)).norm(), 1e-12 * pairs.Phi.col(0).norm());
  const Matrix diagonal = pairs.Phi.transpose() * K * pairs.Phi - Matrix(pairs.lambda.asDiagonal());
  EXPECT_LT(diagonal.cwiseAbs().maxCoeff(), 1e-12 * pairs.lambda(n - 1));
}

TEST(DenseEigenpairsBeside, IsTheSameAsWithoutWhereNothingIsClose) {
  const Index N = 3;
  const Matrix K = grid_stiffness(N, false);
  const Vector exact = grid_eigenvalues(N, false);
  const Matrix Q = Matrix::Ones(K.rows(), 1) / std::sqrt(static_cast<double>(K.rows()));
  const Eigenpairs pairs = dense_eigenpairs_beside(K, Q);
  ASSERT_TRUE(pairs.converged);
  EXPECT_LT((pairs.lambda - exact).cwiseAbs().maxCoeff(), 1e-13 * exact.maxCoeff());
  EXPECT_LT((K * pairs.Phi - pairs.Phi * pairs.lambda.asDiagonal()).norm(), 1e-12);
  EXPECT_LT((pairs.Phi.transpose() * pairs.Phi - Matrix::Identity(K.rows(), K.rows())).norm(),
            1e-12);
}

}  // namespace
}  // namespace cbr::test::eigenpairs_test
