// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace cbr::parallel_test {

TEST(RunThreads, DoesEveryShareOnce) {
  for (const int n : {0, 1, 2, 7}) {
    std::vector<std::atomic<int>> done(7);
    run_threads(n, [&](int t) { ++done[static_cast<std::size_t>(t)]; });
    for (int t = 0; t < 7; ++t) EXPECT_EQ(done[static_cast<std::size_t>(t)], t < n ? 1 : 0);
  }
}

TEST(RunThreads, HandsOnTheFirstExceptionWhenAllHaveEnded) {
  std::atomic<int> ended{0};
  try {
    run_threads(4, [&](int t) {
      ++ended;
      if (t > 0) throw std::runtime_error("thread " + std::to_string(t));
    });
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "thread 1");
  }
  EXPECT_EQ(ended, 4);
}

}  // namespace cbr::parallel_test
