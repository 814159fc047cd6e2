// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/tie.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/linalg/dense.hpp"
#include "tests/unit/dynamics/patch.hpp"

namespace cbr::tie_test {
namespace {

using test::Patch, test::patch;

// A slave of body 0 over a master of body 1.
struct Ties {
  ContactList list;
  Points offsets;
  TieReport report;
};

Ties tied(Patch slave, Patch master, std::optional<double> tolerance = {}) {
  slave.surface.body = 0;
  master.surface.body = 1;
  Ties t;
  t.report = tie_surfaces(slave.surface, slave.body.start, master.surface, master.body.start,
                          tolerance, t.list, t.offsets);
  return t;
}

// sum of coefficient x f(position) over a point's terms
template <typename Field>
Vector3 sum(const Ties& t, const ContactPoint& point, const Patch& slave, const Patch& master,
            const Field& field) {
  Vector3 r = Vector3::Zero();
  for (Index k = point.first_term; k < point.first_term + point.n_terms; ++k) {
    const ContactTerm& term = t.list.terms[k];
    const Points& x = (term.body == 0 ? slave : master).body.start;
    r += term.coefficient * field(Vector3(x.row(term.node).transpose()));
  }
  return r;
}

TEST(Tie, EveryNodeIsTiedToWhatItLiesOn) {
  const Patch slave = patch(7, 0.003, false), master = patch(5, 0, true);  // 5 % of a face is 0.01
  const Ties t = tied(slave, master);
  ASSERT_EQ(t.list.points.size(), 64u);
  EXPECT_EQ(t.report.without_partner, 0);
  EXPECT_NEAR(t.report.largest_offset, 0.003, 1e-15);
  const Matrix3 A = (Matrix3() << 1, 2, 3, -1, 0.5, 0.2, 2, -3, 1).finished();
  double area = 0;
  for (std::size_t i = 0; i < t.list.points.size(); ++i) {
    const ContactPoint& point = t.list.points[i];
    EXPECT_EQ(point.frame, Matrix3::Identity());
    EXPECT_NEAR(
        (sum(t, point, slave, master, [](const Vector3& x) { return x; }) - Vector3(0, 0, 0.003))
            .norm(),
        0, 1e-14);
    EXPECT_NEAR((t.offsets.row(static_cast<Index>(i)) - Vector3(0, 0, 0.003).transpose()).norm(), 0,
                1e-14);
    // A linear field that does not see the offset is taken over exactly; so is any translation
    const auto linear = [&](const Vector3& x) { return Vector3(A * Vector3(x[0], x[1], 1)); };
    EXPECT_NEAR(sum(t, point, slave, master, linear).norm(), 0, 1e-13);
    area += point.area;
  }
  EXPECT_NEAR(area, 1, 1e-13);
}

TEST(Tie, TheClosestFaceWithinTheTolerance) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  Patch slave = patch(9, 0.01, false, 1.3), master = patch(6, 0, true);
  for (Index i = 0; i < slave.body.start.rows(); ++i) slave.body.start(i, 2) += 0.03 * unit(random);
  for (Index i = 0; i < master.body.start.rows(); ++i)
    master.body.start(i, 2) += 0.03 * unit(random);
  const double tolerance = 0.02;
  const Ties t = tied(slave, master, tolerance);
  std::vector<double> found(100, HUGE_VAL);
  for (std::size_t i = 0; i < t.list.points.size(); ++i)
    found[t.list.points[i].slot] = t.offsets.row(static_cast<Index>(i)).norm();
  Index without = 0;
  for (Index i = 0; i < 100; ++i) {
    double nearest = HUGE_VAL;
    for (Index f = 0; f < 36; ++f) {
      const FaceCorners x = corners(master.surface, f, master.body.start);
      const Projection p = project(x, false, slave.body.start.row(i).transpose());
      Vector3 d = slave.body.start.row(i).transpose();
      for (int a = 0; a < 4; ++a) d -= p.weights[a] * x[a];
      nearest = std::min(nearest, d.norm());
    }
    without += nearest > tolerance;
    EXPECT_EQ(found[i], nearest <= tolerance ? nearest : HUGE_VAL);
  }
  EXPECT_EQ(t.report.without_partner, without);
  EXPECT_GT(without, 20);
  EXPECT_LT(without, 80);
}

// Relative rigid motions see as many rows as there are motions: six of a face, five of a line,
// three of a point.
TEST(Tie, RigidBodiesKeepTheRowsThatAreIndependent) {
  for (const Index rank : {6, 5, 3}) {
    Patch slave = patch(3, 0.003, false), master = patch(2, 0, true);
    if (rank < 6) slave.body.start.col(1).setConstant(0.4);
    if (rank < 5) slave.body.start.col(0).setConstant(0.3);
    Ties t = tied(slave, master);
    ASSERT_EQ(t.report.n_points, 16);
    keep_independent(0, slave.body.start, t.list, t.offsets);
    Matrix rows(3 * static_cast<Index>(t.list.points.size()), 6);
    double area = 0;
    for (std::size_t i = 0; i < t.list.points.size(); ++i) {
      const ContactPoint& point = t.list.points[i];
      const Vector3 x = slave.body.start.row(t.list.terms[point.first_term].node).transpose();
      Matrix motions(3, 6);  // of the slave alone
      motions << Matrix3::Identity(),
          (Matrix3() << 0, x[2], -x[1], -x[2], 0, x[0], x[1], -x[0], 0).finished();
      rows.middleRows(3 * static_cast<Index>(i), 3) = point.frame * motions;
      area += point.area;
      EXPECT_NEAR((t.offsets.row(static_cast<Index>(i)) - Vector3(0, 0, 0.003).transpose()).norm(),
                  0, 1e-14);
    }
    EXPECT_NEAR(area, 1, 1e-13);
    EXPECT_EQ((rows.rowwise().norm().array() > 1e-9).count(), rank);
    EXPECT_EQ((symmetric_eigenvalues(rows * rows.transpose()).array() > 1e-3).count(), rank);
  }
}

TEST(Tie, MortarCountsTheNodesThatNothingHolds) {
  // The slave's second column of faces reaches 1 % over the master's rim, its third lies beyond
  Patch slave = patch(4, 0, false), master = patch(3, 0, true);
  slave.surface.body = 0;
  master.surface.body = 1;
  slave.body.start.col(0).array() += 0.7475;
  Ties t;
  t.report = tie_mortar(slave.surface, slave.body.start, master.surface, master.body.start, {}, {},
                        t.list, t.offsets);
  std::vector<char> held(25, 0);
  for (const ContactTerm& term : t.list.terms)
    if (term.body == 0) held[term.node] = 1;
  EXPECT_EQ(t.report.without_partner, std::count(held.begin(), held.end(), 0));
  EXPECT_EQ(t.report.without_partner, 10);  // x > 1.25
  EXPECT_LT(t.list.points.size(), 15u);     // some of the held ones have no point of their own
}

TEST(Tie, NothingNearNothingTied) {
  const Ties t = tied(patch(3, 1, false), patch(3, 0, true));
  EXPECT_TRUE(t.list.empty());
  EXPECT_EQ(t.offsets.rows(), 0);
  EXPECT_EQ(t.report.without_partner, 16);
}

}  // namespace
}  // namespace cbr::tie_test
