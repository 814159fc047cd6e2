// SPDX-License-Identifier: GPL-3.0-or-later
// Friction where the response is singular: more rows than the bodies have ways to give way.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dynamics/contact/solve/contact_solver.hpp"
#include "tests/unit/dynamics/contact_problems.hpp"

namespace cbr::singular_friction_test {
namespace {

using test::all;
using test::dense;
using test::judge;
using test::random_matrix;
using test::Verdict;

// 3 m rows of a rank far below: rigid motions, among them one that opens all gaps, and a few
// shapes. All laws together.
struct FewShapes {
  GapResponse W;
  std::vector<PointLaw> laws;
  Vector g;
};

FewShapes few_shapes(std::mt19937& random, Index n, Index shapes, Index n_tied, double friction) {
  FewShapes problem;
  for (Index i = 0; i < n; ++i)
    problem.laws.push_back(i < n_tied   ? PointLaw{ContactLaw::tied, 0}
                           : i % 5 == 4 ? PointLaw{}
                                        : PointLaw{ContactLaw::coulomb, friction});
  const Index m = first_rows(problem.laws).back();
  const Matrix points = random_matrix(random, n, 2),
               bent = 0.3 * random_matrix(random, 3 * n, shapes);
  Matrix G(m, 6 + shapes);
  Index row = 0;
  for (Index i = 0; i < n; ++i) {
    const double y = points(i, 0), z = points(i, 1);
    Matrix rigid = Matrix::Zero(3, 6 + shapes);
    rigid(0, 0) = rigid(1, 1) = rigid(2, 2) = 1;
    rigid(0, 3) = y;
    rigid(0, 4) = z;
    rigid(1, 5) = -z;
    rigid(2, 5) = y;
    rigid.rightCols(shapes) = bent.middleRows(3 * i, 3);
    G.middleRows(row, n_rows(problem.laws[i].law)) = rigid.topRows(n_rows(problem.laws[i].law));
    row += n_rows(problem.laws[i].law);
  }
  problem.W = dense(G * G.transpose());
  // A motion closes the tied rows and opens all others by more than mu times the slip that goes
  // with it, so that impulses exist (Acary and others 2011); without tied rows a translation does
  problem.g = 0.3 * random_matrix(random, m, 1);
  Vector opening = Vector::Zero(m);  // by that motion
  if (n_tied > 0) {
    Vector motion = random_matrix(random, 6 + shapes, 1);
    motion[0] += 2;
    opening = G * motion;
    problem.g.head(3 * n_tied).setZero();
    problem.g -= opening;
  }
  row = 0;
  for (const PointLaw& law : problem.laws) {
    if (law.law != ContactLaw::tied && n_tied == 0) problem.g[row] -= 0.5;
    if (law.law != ContactLaw::tied && n_tied > 0) {
      const double slip =
          law.law == ContactLaw::coulomb ? (problem.g + opening).segment<2>(row + 1).norm() : 0;
      problem.g[row] = std::max(0.4, friction * slip + 0.1) - opening[row];
    }
    row += n_rows(law.law);
  }
  return problem;
}

TEST(SingularFriction, FrictionOnMorePointsThanShapes) {
  std::mt19937 random(14);
  Verdict seen;
  for (int trial = 0; trial < 120; ++trial) {
    const Index n = 8 + trial % 23;
    const FewShapes problem = few_shapes(random, n, trial % 7, 0, trial % 2 ? 0.3 : 0.1);
    ContactSolver solver(problem.W, problem.laws);
    const auto result = solver.solve(problem.g, Vector());
    const Verdict v = judge(problem.W, problem.laws, problem.g, result);
    EXPECT_LT(v.law, 1e-7) << "trial " << trial;
    EXPECT_LT(v.gap, 1e-9);
    EXPECT_LT(result.residual, 1e-9) << "trial " << trial;
    seen.open += v.open;
    seen.stick += v.stick;
    seen.slide += v.slide;
    // A little later, from there
    const Vector later = 1.01 * problem.g;
    EXPECT_LT(solver.solve(later, result.p).residual, 1e-9) << "trial " << trial;
  }
  EXPECT_GT(std::min({seen.open, seen.stick, seen.slide}), 10);
}

TEST(SingularFriction, BesideATiedPoint) {
  std::mt19937 random(15);
  for (int trial = 0; trial < 100; ++trial) {
    const FewShapes problem =
        few_shapes(random, 8 + trial % 23, trial % 7, 1, trial % 2 ? 0.3 : 0.1);
    ContactSolver solver(problem.W, problem.laws);
    const auto result = solver.solve(problem.g, Vector());
    EXPECT_LT(result.residual, 1e-9) << "trial " << trial;
    EXPECT_LT(judge(problem.W, problem.laws, problem.g, result).law, 1e-7) << "trial " << trial;
  }
}

// No friction but for the name, and more than there is a solution for: bounded work, and a residual
// that says how good it is.
TEST(SingularFriction, VeryLittleAndVeryMuch) {
  for (const double friction : {1e-12, 1e-9, 1e-7, 1.0, 3.0, 1e6}) {
    std::mt19937 random(17);
    for (int trial = 0; trial < 10; ++trial) {
      const FewShapes problem = few_shapes(random, 30, 6, 0, friction);
      ContactSolver solver(problem.W, problem.laws);
      const auto result = solver.solve(problem.g, Vector());
      EXPECT_LT(result.iterations, 500) << friction;
      const Verdict v = judge(problem.W, problem.laws, problem.g, result);
      EXPECT_LT(v.gap, 1e-9);
      if (friction < 1) {
        EXPECT_LT(result.residual, 1e-9) << friction;
      }
    }
  }
}

// Mirrored points with mirrored gaps get mirrored impulses, whatever W leaves open between them.
TEST(SingularFriction, SymmetricPointsGetSymmetricImpulses) {
  const Index n = 20;
  const auto laws = all(n, ContactLaw::coulomb, 0.3);
  Matrix G = Matrix::Zero(3 * n, 7);
  Vector g(3 * n);
  for (Index i = 0; i < n; ++i) {
    const double side = i % 2 == 0 ? 1 : -1, y = side * (0.5 + static_cast<double>(i / 2 % 5)),
                 z = static_cast<double>(i / 10) - 0.5;
    G(3 * i, 0) = G(3 * i + 1, 1) = G(3 * i + 2, 2) = 1;
    G(3 * i, 3) = 0.3 * y;
    G(3 * i, 4) = z;
    G(3 * i + 1, 5) = -z;
    G(3 * i + 2, 5) = 0.3 * y;
    G(3 * i, 6) = 0.05 * y * y;
    G(3 * i + 1, 6) = 0.1 * y;
    g.segment<3>(3 * i) << -1 + 0.02 * y * y, 0.03 * y, 0.2;
  }
  ContactSolver solver(dense(G * G.transpose()), laws);
  const auto result = solver.solve(g, Vector());
  EXPECT_LT(result.residual, 1e-10);
  const Vector motion = G.transpose() * result.p;
  EXPECT_GT(motion[0], 0.1);
  // Ten times the worst of sums in four orders: 9e-11 to 2e-9
  for (const Index odd : {1, 3, 5}) EXPECT_LT(std::abs(motion[odd]), 2e-8 * motion.norm());
  for (Index i = 0; i < n; i += 2) {
    const Vector3 p = result.p.segment<3>(3 * i), q = result.p.segment<3>(3 * i + 3);
    EXPECT_LT((p - Vector3(q[0], -q[1], q[2])).norm(), 1e-6 * result.p.norm());
  }
}

// One rigid coordinate pressed and dragged: all slides, or all sticks, as one block does.
TEST(SingularFriction, ARigidFaceIsOneBlock) {
  for (const double drag : {0.1, 5.0}) {
    const Index n = 30;
    Matrix G = Matrix::Zero(3 * n, 3);
    Vector g(3 * n);
    for (Index i = 0; i < n; ++i) {
      G.middleRows<3>(3 * i).setIdentity();
      g.segment<3>(3 * i) << -1, drag, 0;
    }
    ContactSolver solver(dense(G * G.transpose()), all(n, ContactLaw::coulomb, 0.3));
    const auto result = solver.solve(g, Vector());
    const Vector force = G.transpose() * result.p;
    EXPECT_NEAR(force[0], 1, 1e-10);
    EXPECT_NEAR(force[1], -std::min(drag, 0.3), 1e-10);
    EXPECT_NEAR(force[2], 0, 1e-10);
  }
}

}  // namespace
}  // namespace cbr::singular_friction_test
