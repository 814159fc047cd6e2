// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/contact_solver.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/dynamics/contact_problems.hpp"

namespace cbr::contact_solver_test {
namespace {

using test::all;
using test::dense;
using test::judge;
using test::Press;
using test::random_matrix;
using test::sparse;
using test::Verdict;

// W = B B^T of the given rank.
Matrix random_response(std::mt19937& random, Index m, Index rank) {
  const Matrix B = random_matrix(random, m, rank);
  return B * B.transpose();
}

// The one p of 2^m active sets that satisfies all conditions; empty when none does (to round-off).
Vector enumerate(const Matrix& W, const Vector& g) {
  const Index m = g.size();
  for (int set = 0; set < (1 << m); ++set) {
    std::vector<Index> A;
    for (Index i = 0; i < m; ++i)
      if (set >> i & 1) A.push_back(i);
    Vector p = Vector::Zero(m);
    if (!A.empty()) p(A) = Vector(Ldlt(Matrix(W(A, A))).solve(Vector(-g(A))));
    if (p.minCoeff() >= 0 && (g + W * p).minCoeff() >= -1e-12) return p;
  }
  return {};
}

void expect_solved(const GapResponse& W, const std::vector<PointLaw>& laws, const Vector& g,
                   const ContactSolution& solution, double tolerance) {
  const Verdict v = judge(W, laws, g, solution);
  EXPECT_LT(v.law, tolerance);
  EXPECT_LT(v.gap, tolerance);
  EXPECT_LT(solution.residual, tolerance);
}

TEST(ContactSolver, AgreesWithEnumerationOfAllSets) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const Index m = 1 + trial % 8;
    const Matrix W = random_response(random, m, m + 2);
    const Vector g = random_matrix(random, m, 1), expected = enumerate(W, g);
    ASSERT_EQ(expected.size(), m);
    ContactSolver solver(dense(W), all(m, ContactLaw::frictionless));
    const auto result = solver.solve(g, trial % 2 ? Vector::Ones(m) : Vector());
    const double condition = W.norm() * Lu(W).inverse().norm();
    EXPECT_LT((result.p - expected).norm(), 1e-14 * condition * (1 + expected.norm()) + 1e-13);
    EXPECT_LT(result.residual, 1e-10);
  }
}

TEST(ContactSolver, MixedLawsHold) {
  std::mt19937 random(2);
  Verdict seen;
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<PointLaw> laws;
    for (int i = 0; i < 1 + trial % 12; ++i) {
      const int kind = static_cast<int>(random() % 4);
      laws.push_back(kind == 0            ? PointLaw{}
                     : kind == 1 && i < 3 ? PointLaw{ContactLaw::tied, 0}
                                          : PointLaw{ContactLaw::coulomb, 0.4});
    }
    const Index m = first_rows(laws).back();
    const GapResponse W = dense(random_response(random, m, m + 3));
    const Vector g = random_matrix(random, m, 1);
    ContactSolver solver(W, laws);
    const auto result = solver.solve(g, Vector());
    expect_solved(W, laws, g, result, 1e-9);
    const Verdict v = judge(W, laws, g, result);
    seen.open += v.open;
    seen.stick += v.stick;
    seen.slide += v.slide;
  }
  EXPECT_GT(seen.open, 100);
  EXPECT_GT(seen.stick, 40);
  EXPECT_GT(seen.slide, 100);
}

TEST(ContactSolver, OnePointObeysCoulombExactlyForAnyFriction) {
  std::mt19937 random(3);
  Verdict seen;
  for (int trial = 0; trial < 3000; ++trial) {
    const std::vector<PointLaw> laws{
        {ContactLaw::coulomb, std::vector{0.01, 0.3, 1.0, 5.0, 100.0}[trial % 5]}};
    const GapResponse W = dense(random_response(random, 3, 6));
    const Vector g = random_matrix(random, 3, 1);
    ContactSolver solver(W, laws);
    const auto result = solver.solve(g, Vector());
    const Verdict v = judge(W, laws, g, result);
    EXPECT_LT(v.law, 1e-9) << trial;
    seen.open += v.open;
    seen.stick += v.stick;
    seen.slide += v.slide;
  }
  EXPECT_GT(std::min({seen.open, seen.stick, seen.slide}), 300);
}

TEST(ContactSolver, MoreContactsThanCoordinates) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 300; ++trial) {
    const Index m = 3 + trial % 38, rank = 1 + trial % 13;
    const Matrix G = random_matrix(random, m, rank);
    // Solvable by construction: some motion y opens every gap
    const Vector y = random_matrix(random, rank, 1);
    const Vector g = Vector(random_matrix(random, m, 1)).cwiseAbs() - G * y;
    ContactSolver solver(dense(G * G.transpose()), all(m, ContactLaw::frictionless));
    const auto result = solver.solve(g, Vector());
    ASSERT_TRUE(result.p.allFinite());
    EXPECT_GE(result.p.minCoeff(), 0);
    EXPECT_LT(result.residual, 1e-9) << "trial " << trial;
    // The motion that they cause is unique though they are not: the least one that opens the gaps,
    // so no longer than y
    EXPECT_LE((G.transpose() * result.p).norm(), y.norm() * (1 + 1e-8));
  }
}

TEST(ContactSolver, DuplicatesShareTheImpulse) {
  for (const auto& laws : {all(2, ContactLaw::frictionless), all(2, ContactLaw::tied),
                           all(2, ContactLaw::coulomb, 0.2)}) {
    // One mass between two identical contacts: W = [w w; w w]
    const Index n = n_rows(laws[0].law);
    Matrix W(2 * n, 2 * n);
    W << 4 * Matrix::Identity(n, n), 4 * Matrix::Identity(n, n), 4 * Matrix::Identity(n, n),
        4 * Matrix::Identity(n, n);
    Vector g = Vector::Zero(2 * n);
    g[0] = g[n] = -8;
    if (n == 3) g[1] = g[4] = 5;
    ContactSolver solver(dense(W), laws);
    const auto result = solver.solve(g, Vector());
    EXPECT_NEAR(result.p[0] + result.p[n], 2, 1e-12);
    if (laws[0].law == ContactLaw::coulomb) {
      EXPECT_NEAR(result.p[1] + result.p[4], -0.4, 1e-12);
    } else {
      EXPECT_LT((result.p.head(n) - result.p.tail(n)).norm(), 1e-7);
    }
    EXPECT_LT(result.residual, 1e-12);
  }
}

TEST(ContactSolver, ImpossibleGapsGiveABoundedAnswerAndSaySo) {
  // A single coordinate squeezed from both sides
  Matrix W(2, 2);
  W << 1, -1, -1, 1;
  ContactSolver solver(dense(W), all(2, ContactLaw::frictionless));
  const auto result = solver.solve(Vector::Constant(2, -1.0), Vector());
  EXPECT_LT(result.p.lpNorm<Eigen::Infinity>(), 10);
  EXPECT_NEAR(result.residual, 1, 1e-6);  // what one side gains the other loses
  std::mt19937 random(5);
  int impossible = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Index m = 4 + trial % 30;
    const GapResponse R = dense(random_response(random, m, m / 3));
    const Vector g = random_matrix(random, m, 1);
    ContactSolver other(R, all(m, ContactLaw::frictionless));
    const auto best = other.solve(g, Vector());
    ASSERT_TRUE(best.p.allFinite());
    EXPECT_GE(best.p.minCoeff(), 0);
    EXPECT_LT((best.gap - g - apply(R, best.p)).norm(), 1e-6 * g.norm());
    impossible += best.residual > 1e-3;
  }
  EXPECT_GT(impossible, 50);
}

TEST(ContactSolver, PointsThatNothingMovesAreReported) {
  Matrix W = Matrix::Zero(4, 4);
  W(3, 3) = 2;
  ContactSolver solver(dense(W), {{ContactLaw::coulomb, 0.5}, {}});
  const auto result = solver.solve(Eigen::Vector4d(-1, 1, 0, -4), Vector());
  EXPECT_NEAR(result.p[3], 2, 1e-12);
  EXPECT_EQ(result.p.head(3).norm(), 0);
  EXPECT_NEAR(result.residual, 0.25, 1e-12);
}

TEST(ContactSolver, NoUnitsMatter) {
  std::mt19937 random(6);
  const std::vector<PointLaw> laws{
      {ContactLaw::coulomb, 0.4}, {}, {ContactLaw::tied, 0}, {ContactLaw::coulomb, 0.4}};
  const Index m = first_rows(laws).back();
  for (int trial = 0; trial < 30; ++trial) {
    const Matrix W = random_response(random, m, m + 2);
    const Vector g = random_matrix(random, m, 1);
    ContactSolver plain(dense(W), laws);
    const Vector expected = plain.solve(g, Vector()).p;
    for (const double w : {1e-12, 1e12})
      for (const double length : {1e-12, 1e12}) {
        ContactSolver solver(dense(w * W), laws);
        const auto result = solver.solve(length * g, Vector());
        EXPECT_LT((result.p * (w / length) - expected).norm(), 1e-9 * expected.norm());
        EXPECT_LT(result.residual, 1e-10);
      }
  }
}

TEST(ContactSolver, LightAndHeavyPointsTogether) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 60; ++trial) {
    const auto laws = all(10, ContactLaw::coulomb, 0.3);
    Matrix B = random_matrix(random, 30, 32);
    for (Index i = 0; i < 10; ++i)
      B.middleRows<3>(3 * i) *= std::pow(10.0, static_cast<double>(i % 4) - 1.5);
    const GapResponse W = dense(B * B.transpose());
    const Vector g = random_matrix(random, 30, 1);
    ContactSolver solver(W, laws);
    expect_solved(W, laws, g, solver.solve(g, Vector()), 1e-8);
  }
}

TEST(ContactSolver, NothingToDo) {
  ContactSolver solver(dense(Matrix::Identity(3, 3)), all(3, ContactLaw::frictionless));
  EXPECT_EQ(solver.solve(Vector::Constant(3, 0.5), Vector::Ones(3)).p.norm(), 0);
  EXPECT_EQ(solver.solve(Vector::Zero(3), Vector::Ones(3)).p.norm(), 0);
  ContactSolver empty(dense(Matrix(0, 0)), {});
  EXPECT_EQ(empty.solve(Vector(), Vector()).p.size(), 0);
}

TEST(ContactSolver, GapsThatAreNotFiniteGetNoImpulse) {
  for (const ContactLaw law : {ContactLaw::frictionless, ContactLaw::coulomb}) {
    ContactSolver solver(dense(Matrix::Identity(6, 6)),
                         all(law == ContactLaw::coulomb ? 2 : 6, law, 0.3));
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), -HUGE_VAL, HUGE_VAL}) {
      Vector g = Vector::Constant(6, -1);
      g[3] = bad;
      const ContactSolution s = solver.solve(g, Vector());
      EXPECT_TRUE(s.p.size() == 6 && s.p.isZero(0));
      EXPECT_EQ(s.residual, HUGE_VAL);
    }
  }
}

TEST(ContactSolver, StartsWhereItEnded) {
  for (const bool soft : {false, true}) {
    for (const auto law : {ContactLaw::frictionless, ContactLaw::coulomb}) {
      const Press press = test::dense_press(13, law, 0.3, soft);
      ContactSolver solver(press.W, press.laws);
      const auto first = solver.solve(press.g, Vector());
      EXPECT_LE(solver.solve(press.g, first.p).iterations, 2);
      // A little later: the same sets, a little more pressed
      const auto later = solver.solve(1.001 * press.g, first.p);
      EXPECT_LE(later.iterations, law == ContactLaw::coulomb ? 3 : 2);
      EXPECT_LT((later.p - 1.001 * first.p).norm(), 1e-8 * first.p.norm());
    }
  }
}

TEST(ContactSolver, TheSameBitsEveryTime) {
  const Press press = test::dense_press(12, ContactLaw::coulomb, 0.3, true);
  ContactSolver a(press.W, press.laws), b(press.W, press.laws);
  EXPECT_EQ((a.solve(press.g, Vector()).p - b.solve(press.g, Vector()).p).norm(), 0);
}

TEST(ContactSolver, SparseAndDenseAgree) {
  for (const auto law : {ContactLaw::frictionless, ContactLaw::coulomb, ContactLaw::tied}) {
    const Press press = test::sparse_press(14, law, 0.4);
    ContactSolver a(press.W, press.laws), b(dense(Matrix(press.W.sparse)), press.laws);
    const auto of_sparse = a.solve(press.g, Vector()), of_dense = b.solve(press.g, Vector());
    EXPECT_LT((of_sparse.p - of_dense.p).norm(), 1e-9 * of_dense.p.norm());
  }
}

TEST(ContactSolver, StrongFriction) {
  for (const bool soft : {false, true}) {
    const Press press = test::dense_press(15, ContactLaw::coulomb, 5, soft);
    ContactSolver solver(press.W, press.laws);
    expect_solved(press.W, press.laws, press.g, solver.solve(press.g, Vector()), 1e-9);
  }
}

// Random responses that couple pressing and slipping as no body does: most are solved, and those
// that are not are reported.
TEST(ContactSolver, StrongFrictionOnWildResponsesEndsAndIsHonest) {
  std::mt19937 random(9);
  int solved = 0;
  for (int trial = 0; trial < 120; ++trial) {
    const Index n = 1 + trial % 30;
    const auto laws = all(n, ContactLaw::coulomb, 5);
    const GapResponse W = dense(random_response(random, 3 * n, trial % 4 ? 3 * n + 2 : n + 3));
    const Vector g = random_matrix(random, 3 * n, 1);
    ContactSolver solver(W, laws);
    const auto result = solver.solve(g, Vector());
    ASSERT_TRUE(result.p.allFinite());
    EXPECT_LT((result.gap - g - apply(W, result.p)).norm(), 1e-6 * g.norm());
    if (trial % 4) solved += result.residual < 1e-9;
    if (result.residual < 1e-9) {
      EXPECT_LT(judge(W, laws, g, result).law, 1e-6);
    }
    EXPECT_LT(result.iterations, 2500);
  }
  EXPECT_GE(solved, 85);  // of 90
}

TEST(ContactSolver, ManyPointsDense) {
  for (const bool soft : {false, true}) {
    const Press press = test::dense_press(46, ContactLaw::frictionless, 0, soft);
    ContactSolver solver(press.W, press.laws);
    expect_solved(press.W, press.laws, press.g, solver.solve(press.g, Vector()), 1e-9);
  }
  const Press press = test::dense_press(30, ContactLaw::coulomb, 0.3, true);
  ContactSolver solver(press.W, press.laws);
  const auto result = solver.solve(press.g, Vector());
  expect_solved(press.W, press.laws, press.g, result, 1e-9);
  EXPECT_FALSE(result.fallback);
}

TEST(ContactSolver, ManyPointsSparse) {
  for (const auto law : {ContactLaw::frictionless, ContactLaw::coulomb}) {
    Press press = test::sparse_press(100, law, 0.3);
    ContactSolver solver(press.W, press.laws);
    const auto result = solver.solve(press.g, Vector());
    expect_solved(press.W, press.laws, press.g, result, 1e-9);
    EXPECT_FALSE(result.fallback);
  }
  // Mixed: every third point tied
  Press press = test::sparse_press(60, ContactLaw::coulomb, 0.3);
  for (std::size_t i = 0; i < press.laws.size(); i += 3) press.laws[i] = {ContactLaw::tied, 0};
  ContactSolver solver(press.W, press.laws);
  expect_solved(press.W, press.laws, press.g, solver.solve(press.g, Vector()), 1e-9);
}

}  // namespace
}  // namespace cbr::contact_solver_test
