// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/child_process.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <stdexcept>

namespace cbr {
namespace {

TEST(ChildProcess, TellsWhatCameBack) {
  int here = 0;
  EXPECT_TRUE(survives_in_child([&] { here = 1; }, 10));
  EXPECT_EQ(here, 0);  // it was a copy
  EXPECT_TRUE(survives_in_child([] { throw std::runtime_error("the parent comes to it, too"); }, 10));
  EXPECT_FALSE(survives_in_child([] { std::abort(); }, 10));
  EXPECT_FALSE(survives_in_child([] { std::_Exit(3); }, 10));
}

TEST(ChildProcess, EndsWhatNeverEnds) {
  volatile bool ever = true;
  EXPECT_FALSE(survives_in_child(
      [&] {
        while (ever) continue;
      },
      1));
}

// Whatever the library does with a large sound file, it is given the time.
TEST(ChildProcess, MoreTimeForLargerFiles) {
  EXPECT_GE(seconds_to_read(0), 1u);
  EXPECT_GT(seconds_to_read(2'000'000'000), 1000u);
  EXPECT_GT(seconds_to_read(static_cast<std::uintmax_t>(-1)), 1000u);
}

}  // namespace
}  // namespace cbr
