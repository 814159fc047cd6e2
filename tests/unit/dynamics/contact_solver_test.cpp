// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/contact_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/unit/dynamics/contact_problems.hpp"

namespace cbr {
namespace {

using test::all;
using test::dense;
using test::judge;
using test::random_matrix;
using test::sparse;
using test::Verdict;

// W = B B^T of the given rank.
Matrix random_response(std::mt19937& random, Index m, Index rank) {
  const Matrix B = random_matrix(random, m, rank);
  return B * B.transpose();
}

TEST(ContactSolver, MixedLawsHold) {
  std::mt19937 random(1);
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
    const Verdict v = judge(W, laws, g, result);
    EXPECT_LT(v.law, 1e-9) << "trial " << trial << " residual " << result.residual << " m " << m;
    EXPECT_LT(v.gap, 1e-10);
    EXPECT_LT(result.residual, 1e-9) << "trial " << trial;
    seen.open += v.open, seen.stick += v.stick, seen.slide += v.slide;
  }
  EXPECT_GT(seen.open, 100);
  EXPECT_GT(seen.stick, 40);
  EXPECT_GT(seen.slide, 100);
}

}  // namespace
}  // namespace cbr
