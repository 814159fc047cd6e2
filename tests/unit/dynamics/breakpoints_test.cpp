// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/loads.hpp"

#include <gtest/gtest.h>

#include <tuple>
#include <vector>

namespace cbr::breakpoints_test {
namespace {

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
}  // namespace cbr::breakpoints_test
