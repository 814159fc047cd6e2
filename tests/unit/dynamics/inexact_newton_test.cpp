// SPDX-License-Identifier: GPL-3.0-or-later
// Friction on a dense static compliance: Newton's inexact steps against sweeps, and its parts
// against dense arithmetic.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "common/files/state_archive.hpp"
#include "dynamics/contact/solve/block_gauss_seidel.hpp"
#include "dynamics/contact/solve/newton/closed_unknowns.hpp"
#include "dynamics/contact/solve/newton/inexact_newton.hpp"
#include "dynamics/contact/solve/newton/krylov.hpp"
#include "dynamics/contact/solve/newton/local_inverse.hpp"
#include "tests/unit/dynamics/contact_problems.hpp"

namespace {

using cbr::ContactLaw;
using cbr::Index;
using cbr::Matrix;
using cbr::Vector;
using cbr::test::Press;
using FloatVector = Eigen::VectorXf;

// A face of n x n points: 1 / distance, and some shapes that move all of it, as a superelement with
// statics answers.
Press face(Index n, double friction) {
  Press press = cbr::test::dense_press(n, ContactLaw::coulomb, friction, true);
  std::mt19937 random(7);
  Matrix shapes(3 * n * n, 12);
  for (Index k = 0; k < n * n; ++k) {
    const double x = static_cast<double>(k % n) / static_cast<double>(n),
                 y = static_cast<double>(k / n) / static_cast<double>(n);
    for (Index d = 0; d < 3; ++d)
      for (Index s = 0; s < 12; ++s)
        shapes(3 * k + d, s) = s / 4 == d ? std::pow(x, s % 2) * std::pow(y, s % 4 / 2)
                                          : 0.1 * std::sin(3 * x + 2 * y + static_cast<double>(s));
  }
  press.W.dense += 2 * shapes * shapes.transpose();
  return press;
}

// Gaps of the ball at a time of its way: it is pressed, dragged along one side and lifted.
Vector gaps_at(Index n, double time) {
  Vector g(3 * n * n);
  const double half = 0.5 * static_cast<double>(n - 1);
  for (Index k = 0; k < n * n; ++k) {
    const double x = (static_cast<double>(k % n) - half) / half - 0.3 * time,
                 y = (static_cast<double>(k / n) - half) / half;
    g[3 * k] = 1e-3 * (x * x + y * y - 0.8 * std::sin(3 * time));
    g[3 * k + 1] = 6e-5 * time * time;
    g[3 * k + 2] = 2e-5 * (x - y);
  }
  return g;
}

cbr::ContactSet set_of(const cbr::ContactProblem& problem) {
  const Vector p = Vector::Zero(problem.n_rows());
  Vector gap = gaps_at(
      static_cast<Index>(std::lround(std::sqrt(static_cast<double>(problem.n_points())))), 0.6);
  return contact_set(problem, p, gap);
}

}  // namespace

TEST(InexactNewton, FollowsAPressAsSweepsDo) {
  const Index n = 8;
  Index slid = 0, stuck = 0;
  for (const double friction : {0.05, 0.3, 0.8}) {
    const Press press = face(n, friction);
    cbr::ContactSolver solver(press.W, press.laws);
    const cbr::ContactProblem problem = contact_problem(press.W, press.laws);
    const cbr::BlockGaussSeidel sweeps(problem);
    Vector guess;
    for (int step = 1; step <= 10; ++step) {
      const Vector g = gaps_at(n, 0.1 * step);
      const double scale = g.lpNorm<Eigen::Infinity>();
      const cbr::ContactSolution found = solver.solve(g, guess);
      guess = found.p;
      EXPECT_FALSE(found.fallback) << friction << " " << step;
      EXPECT_LE(found.residual, 1e-10) << friction << " " << step;
      const cbr::test::Verdict verdict = cbr::test::judge(press.W, press.laws, g, found);
      EXPECT_LE(verdict.law, 1e-9) << friction << " " << step;
      EXPECT_LE(verdict.gap, 1e-13) << friction << " " << step;
      slid += verdict.slide;
      stuck += verdict.stick;
      Vector p = found.p, gap = found.gap;
      p *= 0.9;
      gap = g + press.W.dense * p;
      sweeps.sweep(problem, 20000, 1e-13 * scale, p, gap);
      EXPECT_LE((p - found.p).lpNorm<Eigen::Infinity>(), 1e-8 * found.p.lpNorm<Eigen::Infinity>())
          << friction << " " << step;
    }
  }
  EXPECT_GT(slid, 20);
  EXPECT_GT(stuck, 20);
}

// All laws at once, no guess, points that nothing moves among them.
TEST(InexactNewton, MixedLaws) {
  const Index n = 9;
  Press press = face(n, 0.4);
  std::vector<Index> rows;
  std::vector<cbr::PointLaw> laws;
  for (Index k = 0; k < n * n; ++k) {
    const ContactLaw law = k % 7 == 3    ? ContactLaw::frictionless
                           : k % 11 == 5 ? ContactLaw::tied
                                         : ContactLaw::coulomb;
    laws.push_back({law, law == ContactLaw::coulomb ? 0.4 : 0});
    for (Index d = 0; d < n_rows(law); ++d) rows.push_back(3 * k + d);
    if (k != 40) continue;
    press.W.dense.middleRows(3 * k, 3).setZero();
    press.W.dense.middleCols(3 * k, 3).setZero();
  }
  const Vector all = gaps_at(n, 0.5);
  Vector g = all(rows);
  Index row = 0;
  for (Index k = 0; k < 40; ++k) row += n_rows(laws[k].law);
  g[row] = 1e-4;
  const cbr::GapResponse W = cbr::test::dense(press.W.dense(rows, rows));
  cbr::ContactSolver solver(W, laws);
  const cbr::ContactSolution found = solver.solve(g, Vector());
  EXPECT_FALSE(found.fallback);
  EXPECT_LE(found.residual, 1e-10);
  EXPECT_LE(cbr::test::judge(W, laws, g, found).law, 1e-9);
}

TEST(InexactNewton, RestoredItGoesOnWithTheSameBits) {
  const Index n = 8;
  const Press press = face(n, 0.3);
  cbr::ContactSolver solver(press.W, press.laws);
  Vector guess;
  for (int step = 1; step <= 4; ++step) guess = solver.solve(gaps_at(n, 0.15 * step), guess).p;
  const auto archive =
      cbr::StateArchive::saved([&](cbr::StateArchive& to) { solver.keep_state(to); });
  cbr::StateArchive from(archive.words(), "state");
  cbr::ContactSolver other(cbr::test::dense(Matrix::Identity(3, 3)), {{ContactLaw::coulomb, 0.1}});
  other.keep_state(from);
  from.finish();
  Vector other_guess = guess;
  for (int step = 5; step <= 8; ++step) {
    guess = solver.solve(gaps_at(n, 0.15 * step), guess).p;
    other_guess = other.solve(gaps_at(n, 0.15 * step), other_guess).p;
    EXPECT_EQ(guess, other_guess) << step;
  }
}

TEST(ClosedResponse, ProductsAreThoseOfW) {
  const Press press = face(7, 0.3);
  const cbr::ContactProblem problem = contact_problem(press.W, press.laws);
  cbr::ClosedResponse closed;
  closed.begin(problem);
  std::vector<char> kept(49, 0);
  for (Index k = 0; k < 40; ++k) closed.add(problem, {(k * 11) % 49});
  for (int pass = 0; pass < 3; ++pass) {
    const Index n = closed.n_rows();
    FloatVector x = FloatVector::Random(n), y, normal;
    std::vector<char> serves(static_cast<std::size_t>(n), 0);
    for (const Index point : closed.points())
      for (Index d = 0; closed.first_row(point) >= 0 && d < 3; ++d)
        serves[closed.first_row(point) + d] = 1;
    for (Index i = 0; i < n; ++i)
      if (!serves[i]) x[i] = 0;
    closed.product(x, y);
    closed.normal_product(problem, x, normal);
    Vector p = Vector::Zero(problem.n_rows());
    for (Index i = 0; i < n; ++i) p[closed.rows()[i]] = closed.scale(i) * static_cast<double>(x[i]);
    const Vector gap = press.W.dense * p;
    const double size = gap.lpNorm<Eigen::Infinity>() * closed.scale(0);
    for (Index i = 0; i < n; ++i)
      if (serves[i]) EXPECT_NEAR(y[i], closed.scale(i) * gap[closed.rows()[i]], 1e-6 * size);
    for (Index i = 0; i < 49; ++i)
      EXPECT_NEAR(normal[i], closed.point_scale(i) * gap[3 * i], 1e-6 * size);
    for (Index k = 0; k < 49; ++k) kept[k] = (k + pass) % 3 != 0;
    closed.keep(kept);
    for (Index k = 0; k < 49; ++k) EXPECT_TRUE(kept[k] || closed.first_row(k) < 0);
    // it rested, or is new
    if (pass == 0) closed.add(problem, {closed.first_row(0) < 0 ? Index{0} : Index{3}});
  }
}

// With so few points all are neighbours, and G^T G is the inverse of the normals' block and of the
// tangential block.
TEST(LocalInverse, IsTheInverseWhereAllAreNeighbours) {
  const Press press = face(2, 0.3);
  const cbr::ContactProblem problem = contact_problem(press.W, press.laws);
  cbr::ContactSet set = set_of(problem);
  set.states = {cbr::PointState::stick, cbr::PointState::slide, cbr::PointState::open,
                cbr::PointState::stick};
  set.slides.row(1) << 0.6, 0.8, 2 * problem.w[1];
  cbr::ClosedResponse closed;
  closed.begin(problem);
  closed.add(problem, {3, 0, 1});
  cbr::ClosedUnknowns unknowns;
  unknowns.build(problem, set, closed);
  ASSERT_EQ(unknowns.size(), 8);
  ASSERT_EQ(unknowns.n_normals(), 3);
  cbr::LocalInverse inverse;
  inverse.build(closed, unknowns, cbr::Neighbours(problem));
  // R over the problem's rows, scaled
  Matrix R = Matrix::Zero(12, 8);
  Vector alpha(8);
  for (Index i = 0; i < 8; ++i) {
    alpha[i] = unknowns[i].alpha;
    for (Index d = 0; d < 3; ++d)
      R(3 * unknowns.point(i) + d, i) = unknowns[i].c[d] * closed.point_scale(unknowns.point(i));
  }
  EXPECT_NEAR(alpha.sum(), 2, 1e-15);
  Matrix A = R.transpose() * press.W.dense * R + Matrix(alpha.asDiagonal());
  A.topRightCorner(3, 5).setZero();
  A.bottomLeftCorner(5, 3).setZero();
  const FloatVector b = FloatVector::LinSpaced(8, -1, 2);
  FloatVector x = b;
  inverse.apply(x);
  const Vector residual = A * x.cast<double>() - b.cast<double>();
  EXPECT_LE(residual.lpNorm<Eigen::Infinity>(), 1e-4);
}

// A row that is kept is the one that is made anew, whichever points open, close, stick or slide.
TEST(LocalInverse, KeepsTheRowsThatStand) {
  const Index n = 5;
  const Press press = face(n, 0.3);
  const cbr::ContactProblem problem = contact_problem(press.W, press.laws);
  const cbr::Neighbours neighbours(problem);
  cbr::ClosedResponse closed;
  closed.begin(problem);
  std::vector<Index> all(static_cast<std::size_t>(n * n));
  std::iota(all.begin(), all.end(), Index{0});
  closed.add(problem, all);
  cbr::LocalInverse kept;
  for (Index pass = 0; pass < 5; ++pass) {
    cbr::ContactSet set = set_of(problem);
    for (Index k = 0; k < n * n; ++k) {
      const bool slides = (k + pass) % 2 == 0;
      set.states[k] = (k * k + pass) % 6 == 3 ? cbr::PointState::open
                      : slides                ? cbr::PointState::slide
                                              : cbr::PointState::stick;
      set.slides.row(k) << 0.6, 0.8, 2 * problem.w[k];
    }
    cbr::ClosedUnknowns unknowns;
    unknowns.build(problem, set, closed);
    cbr::LocalInverse anew;
    kept.build(closed, unknowns, neighbours);
    anew.build(closed, unknowns, neighbours);
    FloatVector x = FloatVector::LinSpaced(unknowns.size(), -1, 2), y = x;
    kept.apply(x);
    anew.apply(y);
    EXPECT_EQ(x, y) << pass;
  }
}

TEST(FloatGmres, SolvesAndKeepsToItsReduction) {
  std::mt19937 random(3);
  const Index n = 60;
  const Matrix B = cbr::test::random_matrix(random, n, n);
  const Eigen::MatrixXf A = (Matrix::Identity(n, n) + 0.05 * B).cast<float>();
  const FloatVector b = FloatVector::Random(n);
  cbr::FloatGmres gmres;
  for (const float reduction : {1e-1F, 1e-3F, 1e-5F}) {
    FloatVector x;
    const int products = gmres.solve([&](const FloatVector& in, FloatVector& out) { out = A * in; },
                                     b, reduction, 50, x);
    EXPECT_LE((b - A * x).norm(), 1.1F * reduction * b.norm());
    EXPECT_LT(products, 30);
    EXPECT_GT(products, 1);
  }
  FloatVector x;
  EXPECT_EQ(gmres.solve([&](const FloatVector& in, FloatVector& out) { out = A * in; },
                        FloatVector::Zero(n), 1e-3F, 50, x),
            0);
  EXPECT_TRUE(x.isZero(0));
}
