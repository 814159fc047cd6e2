// SPDX-License-Identifier: GPL-3.0-or-later
// Contact near the ends of a double: the laws hold, or the solution says that they do not.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "dynamics/contact/solve/newton/contact_newton.hpp"
#include "tests/unit/dynamics/contact_problems.hpp"

namespace cbr::contact_magnitudes_test {
namespace {

using test::dense;
using test::judge;
using test::random_matrix;

struct Problem {
  GapResponse W;
  std::vector<PointLaw> laws;
  Vector g;
};

// Few points of one or all laws; W positive definite, or of too low a rank.
Problem random_problem(std::mt19937& random, int trial) {
  Problem problem;
  const int only = trial % 4;
  for (int i = 0; i < 1 + trial % 9; ++i) {
    const int kind = only < 3 ? only : i % 3;
    problem.laws.push_back(kind == 0   ? PointLaw{}
                           : kind == 1 ? PointLaw{ContactLaw::tied, 0}
                                       : PointLaw{ContactLaw::coulomb, 0.3});
  }
  const Index m = first_rows(problem.laws).back();
  const Matrix B = random_matrix(random, m, trial % 7 == 0 ? std::max<Index>(1, m / 2) : m + 3);
  problem.W = dense(B * B.transpose());
  problem.g = random_matrix(random, m, 1);
  return problem;
}

TEST(ContactMagnitudes, LawsHoldOrTheResidualIsInfinite) {
  std::mt19937 random(21);
  Index n_right = 0, n_named = 0;
  for (int trial = 0; trial < 120; ++trial) {
    const Problem problem = random_problem(random, trial);
    ContactSolver plain(problem.W, problem.laws);
    const bool solvable = plain.solve(problem.g, Vector()).residual < 1e-9;
    for (const int of_W : {-1000, -700, -500, 0, 500, 700, 1000, 1024})
      for (const int of_g : {-1000, -500, 0, 500, 1000}) {
        // Powers of two, so that the problem stays the same
        ContactSolver solver(dense((problem.W.dense.array() * std::ldexp(1.0, of_W / 2) *
                                    std::ldexp(1.0, of_W - of_W / 2))
                                       .matrix()),
                             problem.laws);
        const ContactSolution solution = solver.solve(std::ldexp(1.0, of_g) * problem.g, Vector());
        ASSERT_EQ(solution.p.size(), problem.g.size());
        ASSERT_EQ(solution.gap.size(), problem.g.size());
        ASSERT_TRUE(solution.p.allFinite());
        ASSERT_FALSE(std::isnan(solution.residual));
        if (std::isinf(solution.residual)) {
          EXPECT_TRUE(solution.p.isZero(0));
          ++n_named;
          continue;
        }
        if (!solvable || solution.residual > 1e-9) continue;
        ContactSolution back = solution;
        back.gap *= std::ldexp(1.0, -of_g);
        for (double& p : back.p) p = std::ldexp(p, of_W - of_g);
        EXPECT_LT(judge(problem.W, problem.laws, problem.g, back).law, 1e-8)
            << trial << ' ' << of_W << ' ' << of_g;
        ++n_right;
      }
  }
  EXPECT_GT(n_right, 2000);
  EXPECT_GT(n_named, 100);
}

TEST(ContactMagnitudes, NewtonAlwaysReturnsImpulses) {
  const double huge = std::numeric_limits<double>::infinity();
  for (const double value : {huge, std::nan(""), 1e308}) {
    const ContactProblem problem = contact_problem(dense(Matrix::Constant(6, 6, value)),
                                                   test::all(2, ContactLaw::coulomb, 0.3));
    ContactNewton newton;
    const Vector g = Vector::Constant(6, -1e300);
    const NewtonResult result =
        newton.solve(problem, g, Vector::Zero(6), g, LinearSolver::factor, 30, 1e-12);
    EXPECT_EQ(result.p.size(), 6);
    EXPECT_TRUE(result.p.allFinite());
    EXPECT_EQ(result.converged, value < huge);
  }
}

}  // namespace
}  // namespace cbr::contact_magnitudes_test
