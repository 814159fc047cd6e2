// SPDX-License-Identifier: GPL-3.0-or-later
// Loads that share a history are one load, whatever the body; many histories cut a step where any
// of them bends.
#include <gtest/gtest.h>

#include <random>
#include <tuple>
#include <vector>

#include "dynamics/motion/loads.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::loads_test {
namespace {

TEST(LoadHistory, isThatOfItsPointsWhereverTheyStand) {
  const History points{{0, 1, 3}, {0, -4, 2}};
  const LoadHistory one = points, other = points, copy = one,
                    longer = History{{0, 1, 4}, {0, -4, 2}}, none;
  EXPECT_TRUE(one == other && one == copy &&
              LoadHistory::Hash()(one) == LoadHistory::Hash()(other));
  EXPECT_FALSE(one == longer || one == none || none == one);
  EXPECT_TRUE(none == LoadHistory(History{}));
  for (const double t : {-1.0, 0.0, 0.25, 1.0, 2.5, 7.0})
    EXPECT_EQ(one.value(t), history_value(points, t));
  EXPECT_EQ(none.value(3), 1);
  EXPECT_EQ(one.largest(), 4);
  EXPECT_EQ(none.largest(), 1);
  EXPECT_EQ(one.next_bend(0), 1);
  EXPECT_EQ(one.next_bend(-1), 0);
  EXPECT_EQ(one.next_bend(3), HUGE_VAL);
}

// Against the sorted list of all times.
TEST(LoadHistory, manyCutAStepWhereAnyBends) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  Breakpoints breakpoints;
  std::vector<double> all;
  for (int i = 0; i < 40; ++i) {
    History history;
    for (double t = uniform(random); t < 3; t += 0.1 + uniform(random)) {
      history.time.push_back(t);
      history.value.push_back(i);
    }
    all.insert(all.end(), history.time.begin(), history.time.end());
    breakpoints.add(history);
  }
  std::sort(all.begin(), all.end());
  for (const auto& [t, h] : {std::pair{0.0, 3.0}, {0.5, 0.01}, {1.1, 0.9}}) {
    std::vector<double> ends;
    double at = t;
    breakpoints.cut(t, h, [&](double from, double to, bool) {
      EXPECT_EQ(from, at);
      ends.push_back(at = to);
    });
    std::vector<double> expected(std::upper_bound(all.begin(), all.end(), t),
                                 std::lower_bound(all.begin(), all.end(), t + h));
    expected.push_back(t + h);
    EXPECT_EQ(ends, expected);
  }
}

// Forces on two faces, overlapping and one after the other, and gravity: the same motion as under
// their sum.
TEST(LoadHistory, loadsThatShareOneAreOneLoad) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  test::Part part;
  const History ramp{{0, 0.3, 0.5}, {0, 2, 1}};
  for (const bool mesh : {true, false}) {
    part.mesh = mesh;
    part.both_faces = true;
    Points x[2], v;
    for (int way = 0; way < 2; ++way) {
      Geometry geometry;
      const auto body = test::make_body("b", part, geometry);
      std::mt19937 same = random;
      BodyPlan plan;
      Points sum = Points::Zero(body->n_nodes(), 3);
      for (int load = 0; load < 12; ++load) {
        Points forces = Points::Zero(body->n_nodes(), 3);
        for (Index i = 0; i < 5; ++i)
          forces.row((7 * load + i * i) % body->n_nodes()) << uniform(same), uniform(same),
              uniform(same);
        if (way == 0) plan.loads.push_back(force_load(forces, ramp));
        sum += forces;
      }
      if (way == 1) plan.loads.push_back(force_load(sum, ramp));
      plan.loads.push_back(gravity_load(Vector3(0, 0, 1), ramp));
      plan.loads.push_back(gravity_load(Vector3(0, 2, 1), ramp));
      body->prepare(plan);
      const double h = 0.5 / body->largest_frequency();
      for (int step = 0; step < 50; ++step) {
        body->predict(step * h, h);
        body->accept();
      }
      body->displacements(x[way], v);
    }
    ASSERT_GT(x[0].cwiseAbs().maxCoeff(), 0);
    EXPECT_LT((x[1] - x[0]).cwiseAbs().maxCoeff(), 1e-12 * x[0].cwiseAbs().maxCoeff()) << mesh;
  }
}

using Pieces = std::vector<std::tuple<double, double, bool>>;

Pieces cut(const Breakpoints& breakpoints, double t, double h) {
  Pieces pieces;
  breakpoints.cut(
      t, h, [&](double from, double to, bool whole) { pieces.emplace_back(from, to, whole); });
  return pieces;
}

TEST(Breakpoints, CutAStepWhereHistoriesBend) {
  Breakpoints breakpoints;
  EXPECT_EQ(cut(breakpoints, 1, 2), (Pieces{{1, 3, true}}));
  breakpoints.add({{0, 2, 5}, {1, 2, 3}});
  breakpoints.add({{2, 2.5}, {0, 1}});
  EXPECT_EQ(cut(breakpoints, 1, 2), (Pieces{{1, 2, false}, {2, 2.5, false}, {2.5, 3, false}}));
  EXPECT_EQ(cut(breakpoints, 3, 1), (Pieces{{3, 4, true}}));
  EXPECT_EQ(cut(breakpoints, 2.5, 4), (Pieces{{2.5, 5, false}, {5, 6.5, false}}));
  EXPECT_EQ(cut(breakpoints, 6, 1), (Pieces{{6, 7, true}}));
}

TEST(Breakpoints, AtTheEndsOfAStepOrEqualButForRoundOffCutNothing) {
  Breakpoints breakpoints;
  breakpoints.add({{1, 1.5, 1.5 + 1e-12, 2}, {0, 1, 1, 0}});
  EXPECT_EQ(cut(breakpoints, 1, 1), (Pieces{{1, 1.5, false}, {1.5, 2, false}}));
  EXPECT_EQ(cut(breakpoints, 1 - 1e-12, 0.5), (Pieces{{1 - 1e-12, 1.5 - 1e-12, true}}));
  EXPECT_EQ(cut(breakpoints, 1.5 + 2e-12, 0.5), (Pieces{{1.5 + 2e-12, 2 + 2e-12, true}}));
}

}  // namespace
}  // namespace cbr::loads_test
