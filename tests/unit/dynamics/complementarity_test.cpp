// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/complementarity.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>
#include <random>

namespace cbr {
namespace {

GapResponse dense(const Matrix& W) {
  GapResponse response;
  response.dense = W;
  return response;
}

Matrix random_matrix(std::mt19937& random, Index rows, Index columns) {
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(rows, columns, [&] { return normal(random); });
}

// The one p of 2^m active sets that satisfies all conditions; empty when none does (to round-off).
Vector enumerate(const Matrix& W, const Vector& g) {
  const Index m = g.size();
  for (int set = 0; set < (1 << m); ++set) {
    std::vector<Index> A;
    for (Index i = 0; i < m; ++i)
      if (set >> i & 1) A.push_back(i);
    Vector p = Vector::Zero(m);
    if (!A.empty()) p(A) = Vector(Matrix(W(A, A)).ldlt().solve(Vector(-g(A))));
    if (p.minCoeff() >= 0 && (g + W * p).minCoeff() >= -1e-12) return p;
  }
  return {};
}

TEST(Complementarity, AgreesWithEnumerationOfAllActiveSets) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const Index m = 1 + trial % 8;
    const Matrix B = random_matrix(random, m, m + 2);
    const Matrix W = B * B.transpose();
    const Vector g = random_matrix(random, m, 1);
    const Vector expected = enumerate(W, g);
    ASSERT_EQ(expected.size(), m);
    ComplementaritySolver solver(dense(W));
    const auto result = solver.solve(g, std::vector<char>(m, static_cast<char>(trial % 2)));
    const double condition = W.norm() * W.inverse().norm();
    EXPECT_LT((result.p - expected).norm(), 1e-14 * condition * (1 + expected.norm()) + 1e-13);
    EXPECT_LT(result.residual, 1e-10);
  }
}

TEST(Complementarity, KeepsItsFactorBetweenSolves) {
  std::mt19937 random(2);
  const Matrix B = random_matrix(random, 6, 9);
  const Matrix W = B * B.transpose();
  ComplementaritySolver solver(dense(W));
  for (int trial = 0; trial < 20; ++trial) {
    const Vector g = random_matrix(random, 6, 1);
    EXPECT_LT((solver.solve(g, std::vector<char>(6, 0)).p - enumerate(W, g)).norm(), 1e-9);
  }
}

TEST(Complementarity, MoreContactsThanCoordinates) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Index m = 3 + trial % 6, rank = 1 + trial % 3;
    const Matrix G = random_matrix(random, m, rank);
    // Solvable by construction: some motion y opens every gap.
    const Vector y = random_matrix(random, rank, 1);
    const Vector g = Vector(random_matrix(random, m, 1)).cwiseAbs() - G * y;
    ComplementaritySolver solver(dense(G * G.transpose()));
    const auto result = solver.solve(g, std::vector<char>(m, 0));
    ASSERT_TRUE(result.p.allFinite());
    EXPECT_GE(result.p.minCoeff(), 0);
    EXPECT_LT(result.residual, 1e-8) << "trial " << trial;
  }
}

TEST(Complementarity, DuplicatesShareTheImpulse) {
  // One mass between two identical contacts: W = [w w; w w]
  ComplementaritySolver solver(dense(Matrix::Constant(2, 2, 4.0)));
  const auto result = solver.solve(Vector::Constant(2, -8.0), {0, 0});
  EXPECT_NEAR(result.p[0], 1, 1e-12);
  EXPECT_NEAR(result.p[1], 1, 1e-12);
  EXPECT_LT(result.gap.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Complementarity, ImpossibleGapsGiveAFiniteAnswerAndSaySo) {
  // A single coordinate squeezed from both sides.
  Matrix W(2, 2);
  W << 1, -1, -1, 1;
  ComplementaritySolver solver(dense(W));
  const auto result = solver.solve(Vector::Constant(2, -1.0), {0, 0});
  EXPECT_TRUE(result.p.allFinite());
  EXPECT_GT(result.residual, 0.1);
}

TEST(Complementarity, SparseAndDenseAgree) {
  std::mt19937 random(4);
  const Index m = 60;
  Matrix W = Matrix::Zero(m, m);
  for (Index i = 0; i < m; ++i) {
    W(i, i) = 3;
    if (i > 0) W(i, i - 1) = W(i - 1, i) = 1;
  }
  GapResponse sparse;
  sparse.is_sparse = true;
  sparse.sparse = W.sparseView();
  const Vector g = random_matrix(random, m, 1);
  ComplementaritySolver a(dense(W)), b(std::move(sparse));
  const std::vector<char> guess(m, 0);
  EXPECT_LT((a.solve(g, guess).p - b.solve(g, guess).p).norm(), 1e-12);
}

TEST(Complementarity, OpenGapsNeedNoImpulse) {
  ComplementaritySolver solver(dense(Matrix::Identity(3, 3)));
  EXPECT_EQ(solver.solve(Vector::Constant(3, 0.5), {1, 1, 1}).p.norm(), 0);
}

}  // namespace
}  // namespace cbr
