// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/row_threads.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "common/base/parallel.hpp"

namespace cbr::row_threads_test {
namespace {

TEST(RowThreads, EveryRowOnceInEveryRound) {
  for (const int n_threads : {1, 2, 5}) {
    RowThreads threads(n_threads);
    EXPECT_EQ(threads.size(), n_threads);
    std::vector<int> count(1000, 0);
    constexpr int rounds = 2000;
    for (int round = 0; round < rounds; ++round)
      threads.for_rows(1000, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i) ++count[i];
      });
    EXPECT_EQ(count, std::vector<int>(1000, rounds));
    std::atomic<int> runs = 0;
    threads.run([&](int) { ++runs; });
    EXPECT_EQ(runs.load(), n_threads);
  }
}

TEST(RowThreads, HandOnAnExceptionWhenAllHaveEnded) {
  for (const int thrower : {0, 1, 2}) {
    RowThreads threads(3);
    for (int round = 0; round < 20; ++round) {
      std::atomic<int> ended = 0;
      const auto work = [&](int t) {
        if (t == thrower) throw std::runtime_error("of one");
        ++ended;
      };
      EXPECT_THROW(threads.run(work), std::runtime_error);
      EXPECT_EQ(ended.load(), 2);
      threads.run([&](int) { ++ended; });
      EXPECT_EQ(ended.load(), 5);
    }
  }
}

TEST(RunKeptThreads, DoesEveryShareOnceWhoeverElseCalls) {
  run_threads(3, [](int) {
    for (int round = 0; round < 300; ++round) {
      const int n = 1 + round % 3;
      std::vector<std::atomic<int>> done(3);
      run_kept_threads(n, [&](int t) { ++done[static_cast<std::size_t>(t)]; });
      for (int t = 0; t < 3; ++t) ASSERT_EQ(done[static_cast<std::size_t>(t)], t < n ? 1 : 0);
    }
  });
}

// Each item once, whether the threads are woken for them or not, and an error comes back.
TEST(RowThreads, ItemsAreShared) {
  for (const Index n : {0, 1, 31, 32, 1000}) {
    std::vector<std::atomic<int>> done(static_cast<std::size_t>(n));
    share_among_threads(n, 3, [&](Index i) { ++done[static_cast<std::size_t>(i)]; });
    for (const auto& times : done) ASSERT_EQ(times, 1);
  }
  const auto fail = [](Index i) {
    if (i == 500) throw std::runtime_error("item 500");
  };
  EXPECT_THROW(share_among_threads(1000, 3, fail), std::runtime_error);
}

}  // namespace
}  // namespace cbr::row_threads_test
