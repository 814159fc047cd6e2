// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "common/base/force_table.hpp"

namespace cbr::force_table_test {
namespace {

// A gap from -1 to 2, stiffness 3 below and 4 above.
const ForceTable gap{{-2, -1, 2, 3}, {-3, 0, 0, 4}};

TEST(ForceTable, ContinuesItsFirstAndLastSlope) {
  EXPECT_EQ(gap.value(-5), -12);
  EXPECT_EQ(gap.value(1), 0);
  EXPECT_EQ(gap.value(5), 12);
  EXPECT_EQ(gap.slope(-5), 3);
  EXPECT_EQ(gap.slope(2), 4);
  EXPECT_EQ(gap.energy(4), 8);
  EXPECT_EQ(gap.energy(-3), 6);
}

TEST(ForceTable, MeanOverARangeAndItsSlope) {
  EXPECT_EQ(gap.mean(-2, 3), 0.1);  // (2 - 1.5) / 5
  EXPECT_EQ(gap.mean(3, -2), 0.1);
  EXPECT_EQ(gap.mean_slope(3, 4), 2);
  const double d = 1e-6;
  EXPECT_NEAR(gap.mean_slope(-2, 3), (gap.mean(-2, 3 + d) - gap.mean(-2, 3 - d)) / (2 * d), 1e-9);
}

// A joint at rest at a corner with a force.
TEST(ForceTable, AShortRangeAcrossACornerHasASlopeOfTheTable) {
  const ForceTable corner{{0, 0.3, 1}, {0, 1e6, 1.1e6}};
  for (double range = 1e-3; range > 1e-18; range *= 0.7) {
    const double slope = corner.mean_slope(0.3 - range, 0.3 + 0.5 * range);
    EXPECT_GE(slope, 0);
    EXPECT_LE(slope, 0.5 * corner.steepest());
  }
}

}  // namespace
}  // namespace cbr::force_table_test
