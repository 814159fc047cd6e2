// SPDX-License-Identifier: GPL-3.0-or-later
// The methods that the contact solver chooses from, each alone.
#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/contact/solve/augmented_lagrangian.hpp"
#include "dynamics/contact/solve/block_gauss_seidel.hpp"
#include "dynamics/contact/solve/contact_solver.hpp"
#include "dynamics/contact/solve/newton/contact_newton.hpp"
#include "tests/unit/dynamics/contact_problems.hpp"

namespace cbr::contact_methods_test {
namespace {

using test::all;
using test::dense;
using test::Press;
using test::random_matrix;

double violation(const ContactProblem& problem, const Vector& g, const Vector& p) {
  return law_violations(problem, p, g + respond(problem, p)).lpNorm<Eigen::Infinity>();
}

// Each method alone, against Newton's answer.
TEST(ContactMethods, AllFindTheSameImpulses) {
  for (const ContactLaw law : {ContactLaw::frictionless, ContactLaw::coulomb})
    for (const bool soft : {false, true}) {
      const Press press = test::dense_press(12, law, 0.3, soft);
      const ContactProblem problem = contact_problem(press.W, press.laws);
      const double scale = press.g.lpNorm<Eigen::Infinity>();
      const Vector zero = Vector::Zero(press.g.size());
      Vector p = zero, gap = press.g;
      BlockGaussSeidel(problem).sweep(problem, 5000, 1e-13 * scale, p, gap);
      for (const auto linear : {LinearSolver::factor, LinearSolver::krylov}) {
        ContactNewton newton;
        const Vector start = 0.9 * p;
        const NewtonResult found = newton.solve(
            problem, press.g, start, press.g + respond(problem, start), linear, 30, 1e-12 * scale);
        ASSERT_TRUE(found.converged);
        EXPECT_LT((p - found.p).norm(), 1e-8 * p.norm());
      }
      const AugmentedLagrangian lagrangian(problem);
      ASSERT_TRUE(lagrangian.ok());
      const auto found = lagrangian.solve(problem, press.g, zero, 1e-11 * scale);
      EXPECT_LT(violation(problem, press.g, found.p), 1e-10 * scale);
      EXPECT_LT((p - found.p).norm(), 1e-8 * p.norm());
    }
}

// The released rows alone give the Newton step that a factor of all rows gives, from any impulses.
TEST(ContactMethods, AnInverseGivesTheStepsOfAllSets) {
  const Press press = test::dense_press(6, ContactLaw::coulomb, 0.3, true);
  const ContactProblem problem = contact_problem(press.W, press.laws);
  const Index n = problem.n_points();
  const FullInverse inverse(problem);
  ASSERT_TRUE(inverse.ok());
  std::mt19937 random(3);
  ContactSet set{std::vector<PointState>(n, PointState::stick), Points::Zero(n, 3)};
  for (int trial = 0; trial < 20; ++trial) {
    ASSERT_TRUE(FullInverse::serves(problem, set));
    const Vector wanted =
        SetMatrix(problem, set, LinearSolver::factor).solve(press.g, Vector::Zero(3 * n), 0);
    const Vector from = trial % 2 == 0 ? wanted : Vector(random_matrix(random, 3 * n, 1));
    const Vector found = inverse.solve(problem, set, from, press.g + respond(problem, from));
    EXPECT_LT((found - wanted).norm(), 1e-10 * wanted.norm());
    const auto i = static_cast<Index>(random() % static_cast<unsigned>(n));
    set.states[i] = trial % 3 == 0 ? PointState::open : PointState::slide;
    const double angle = static_cast<double>(random() % 7);
    set.slides.row(i) << std::cos(angle), std::sin(angle),
        (trial % 2 == 0 ? 1e3 : 0.5) * problem.w[i];
  }
  set.states.assign(n, PointState::slide);
  EXPECT_FALSE(FullInverse::serves(problem, set));
}

// Points on a face that moves in polynomials, the higher the lighter: as singular as the response
// of an interface of few shapes.
Matrix smooth_response(Index side, Index degree) {
  const Index m = side * side;
  Matrix G(m, (degree + 1) * (degree + 1));
  for (Index i = 0; i < m; ++i)
    for (Index a = 0; a <= degree; ++a)
      for (Index b = 0; b <= degree; ++b) {
        const double x = 2.0 * static_cast<double>(i % side) / static_cast<double>(side - 1) - 1,
                     y = 2.0 * static_cast<double>(i / side) / static_cast<double>(side - 1) - 1;
        G(i, a * (degree + 1) + b) = std::cos(static_cast<double>(a) * std::acos(x)) *
                                     std::cos(static_cast<double>(b) * std::acos(y)) /
                                     static_cast<double>(1 + a * a + b * b);
      }
  return G;
}

TEST(ContactMethods, TheLagrangianEndsOnAnyResponseWithoutFriction) {
  std::mt19937 random(9);
  for (int trial = 0; trial < 40; ++trial) {
    const Index side = 5 + trial % 8, m = side * side;
    const Matrix G = smooth_response(side, trial % 5);
    // A wall that is rough, over a face that comes closer by 1 on average; a constant motion opens
    // all
    Vector g = 0.1 * random_matrix(random, m, 1).array() - 1;
    for (Index i = 0; trial % 2 == 1 && i < m; ++i)
      g[i] += 2 * G(i, std::min<Index>(1, G.cols() - 1));
    const GapResponse W = dense(G * G.transpose());
    const auto laws = all(m, ContactLaw::frictionless);
    const ContactProblem problem = contact_problem(W, laws);
    const double scale = g.lpNorm<Eigen::Infinity>();
    const auto found = AugmentedLagrangian(problem).solve(problem, g, Vector(), 1e-11 * scale);
    EXPECT_LT(violation(problem, g, found.p), 2e-10 * scale) << trial;
    EXPECT_LT(found.steps, 100);
    EXPECT_GE(found.p.minCoeff(), 0);
    ContactSolver solver(W, laws);
    const ContactSolution solution = solver.solve(g, Vector());
    EXPECT_LT(solution.residual, 1e-9) << trial;
    // the motion is unique
    EXPECT_LT((solution.gap - g - respond(problem, found.p)).lpNorm<Eigen::Infinity>(),
              1e-8 * scale)
        << trial;
  }
  for (int trial = 0; trial < 50; ++trial) {
    const Index m = 60, rank = 10 + trial % 20;
    const Matrix G = random_matrix(random, m, rank);
    const Vector y = random_matrix(random, rank, 1),
                 g = Vector(random_matrix(random, m, 1)).cwiseAbs() - G * y;
    const ContactProblem problem =
        contact_problem(dense(G * G.transpose()), all(m, ContactLaw::frictionless));
    const double scale = g.lpNorm<Eigen::Infinity>();
    const auto found = AugmentedLagrangian(problem).solve(problem, g, Vector(), 1e-11 * scale);
    EXPECT_LT(violation(problem, g, found.p), 1e-10 * scale);
  }
}

// One mass between two walls: each gap is off by the half of what both take.
TEST(ContactMethods, TheLagrangianFindsTheLeastViolation) {
  Matrix W(2, 2);
  W << 1, -1, -1, 1;
  const ContactProblem problem = contact_problem(dense(W), all(2, ContactLaw::frictionless));
  const auto found = AugmentedLagrangian(problem).solve(problem, Vector(Eigen::Vector2d(-1, -0.5)),
                                                        Vector(), 1e-11);
  EXPECT_LT((found.motion - Eigen::Vector2d(-0.75, -0.75)).norm(), 1e-9);
  EXPECT_TRUE(found.p.allFinite());
}

}  // namespace
}  // namespace cbr::contact_methods_test
