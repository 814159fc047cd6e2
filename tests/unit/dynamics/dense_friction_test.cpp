// SPDX-License-Identifier: GPL-3.0-or-later
// Friction on a dense static compliance, by factors and by Krylov methods, against sweeps.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "common/files/state_archive.hpp"
#include "dynamics/contact/solve/block_gauss_seidel.hpp"
#include "tests/unit/dynamics/contact_problems.hpp"

namespace {

using cbr::ContactLaw;
using cbr::Index;
using cbr::Matrix;
using cbr::Vector;
using cbr::test::Press;

// A face of n x n points (8: factors; 12, more than 400 rows: Krylov methods): 1 / distance, and
// some shapes that move all of it, as a superelement with statics answers.
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

}  // namespace

TEST(DenseFriction, FollowsAPressAsSweepsDo) {
  Index slid = 0, stuck = 0;
  for (const auto& [n, friction] :
       std::vector<std::pair<Index, double>>{{8, 0.05}, {8, 0.3}, {8, 0.8}, {12, 0.3}}) {
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
TEST(DenseFriction, MixedLaws) {
  for (const Index n : {9, 13}) {
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
}

TEST(DenseFriction, RestoredItGoesOnWithTheSameBits) {
  for (const Index n : {8, 12}) {
    const Press press = face(n, n == 12 ? 2 : 0.3);  // few points slide: their rows get an inverse
    cbr::ContactSolver solver(press.W, press.laws);
    Vector guess;
    for (int step = 1; step <= 4; ++step) guess = solver.solve(gaps_at(n, 0.15 * step), guess).p;
    for (int step = 1; n == 12 && step <= 20; ++step)
      guess = solver.solve(gaps_at(n, 0.6 + 1e-3 * step), guess).p;
    const auto archive =
        cbr::StateArchive::saved([&](cbr::StateArchive& to) { solver.keep_state(to); });
    cbr::StateArchive from(archive.words(), "state");
    cbr::ContactSolver other(cbr::test::dense(Matrix::Identity(3, 3)),
                             {{ContactLaw::coulomb, 0.1}});
    other.keep_state(from);
    from.finish();
    Vector other_guess = guess;
    for (int step = 5; step <= 8; ++step) {
      guess = solver.solve(gaps_at(n, 0.15 * step), guess).p;
      other_guess = other.solve(gaps_at(n, 0.15 * step), other_guess).p;
      EXPECT_EQ(guess, other_guess) << step;
    }
  }
}
