// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/broad_phase.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace cbr::broad_phase_test {
namespace {

std::vector<Box> random_boxes(std::mt19937& random, int n, const Vector3& spread, double size) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Box> boxes;
  for (int i = 0; i < n; ++i) {
    const Vector3 at(unit(random) * spread[0], unit(random) * spread[1], unit(random) * spread[2]);
    boxes.push_back({at, at + size * Vector3(unit(random), unit(random), unit(random))});
  }
  return boxes;
}

void expect_as_brute_force(const std::vector<Box>& queries, const std::vector<Box>& targets) {
  BroadPhase grid;
  for (int again = 0; again < 2; ++again) {  // the second time with a used workspace
    find_candidates(queries, targets, grid);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      std::vector<Index> expected;
      for (std::size_t t = 0; t < targets.size(); ++t)
        if (queries[i].meets(targets[t])) expected.push_back(static_cast<Index>(t));
      const auto begin = grid.candidates.target.begin();
      EXPECT_EQ(std::vector<Index>(begin + grid.candidates.first[i],
                                   begin + grid.candidates.first[i + 1]),
                expected);
    }
  }
}

TEST(BroadPhase, FindsWhatBruteForceFinds) {
  std::mt19937 random(1);
  for (const Vector3& spread :
       {Vector3(1, 1, 1), Vector3(1, 1, 0), Vector3(10, 0.1, 0), Vector3(0, 0, 0)}) {
    for (const double size : {0.0, 0.05, 0.5, 3.0})
      expect_as_brute_force(random_boxes(random, 80, spread, size),
                            random_boxes(random, 120, spread, size));
  }
}

TEST(BroadPhase, OneHugeAmongSmall) {
  std::mt19937 random(2);
  auto targets = random_boxes(random, 50, Vector3(1, 1, 1), 0.02);
  targets.push_back({Vector3(-100, -100, -100), Vector3(100, 100, 100)});
  expect_as_brute_force(random_boxes(random, 30, Vector3(2, 2, 2), 0.1), targets);
}

TEST(BroadPhase, TwoCloudsThatShareACorner) {
  std::mt19937 random(4);
  for (const double overlap : {0.3, 0.05, 0.0, -0.05}) {
    auto targets = random_boxes(random, 200, Vector3(1, 1, 1), 0.1);
    for (Box& box : targets) {
      box.lower.array() += 1 - overlap;
      box.upper.array() += 1 - overlap;
    }
    expect_as_brute_force(random_boxes(random, 200, Vector3(1, 1, 1), 0.1), targets);
  }
}

TEST(BroadPhase, NothingNearNothingFound) {
  std::mt19937 random(3);
  auto far = random_boxes(random, 20, Vector3(1, 1, 1), 0.1);
  for (Box& box : far) {
    box.lower.array() += 10;
    box.upper.array() += 10;
  }
  expect_as_brute_force(random_boxes(random, 20, Vector3(1, 1, 1), 0.1), far);
  expect_as_brute_force({}, far);
  expect_as_brute_force(far, {});
}

// What a run above the critical step makes of boxes before the loop sees that its energy is
// infinite
TEST(BroadPhase, InfiniteBoxesAreNoCrash) {
  std::mt19937 random(5);
  auto queries = random_boxes(random, 20, Vector3(1, 1, 1), 0.1),
       targets = random_boxes(random, 30, Vector3(1, 1, 1), 0.1);
  for (const double huge : {1.7e308, HUGE_VAL}) {
    queries[3] = targets[7] = {Vector3::Constant(-huge), Vector3::Constant(huge)};
    expect_as_brute_force(queries, targets);
  }
  BroadPhase grid;
  queries[5].upper[1] = targets[2].lower[0] = std::numeric_limits<double>::quiet_NaN();
  find_candidates(queries, targets, grid);
  EXPECT_EQ(grid.candidates.first.size(), queries.size() + 1);
}

}  // namespace
}  // namespace cbr::broad_phase_test
