// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/force_table.hpp"
#include "common/base/process.hpp"
#include "common/base/threads.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::base_test {
namespace {

TEST(ChildProcess, TellsWhatCameBack) {
  int here = 0;
  EXPECT_TRUE(survives_in_child(
      "a.exo", [&] { here = 1; }, 10));
  EXPECT_EQ(here, 0);  // it was a copy
  EXPECT_TRUE(survives_in_child(
      "a.exo", [] { throw std::runtime_error("the parent comes to it, too"); }, 10));
  EXPECT_FALSE(survives_in_child(
      "a.exo", [] { std::abort(); }, 10));
  EXPECT_FALSE(survives_in_child(
      "a.exo", [] { std::_Exit(3); }, 10));
}

// A hangup that nohup ignores, Ctrl-C that the parent notes: not the child's to heed. What kills it
// outright says nothing of the file.
TEST(ChildProcess, SignalsFromOutsideSayNothingOfTheFile) {
  for (const int number : {SIGTERM, SIGINT, SIGHUP})
    EXPECT_TRUE(survives_in_child(
        "a.exo", [&] { std::raise(number); }, 10));
  EXPECT_SAYS(test::refusal_of<RunError>([&] {
                survives_in_child(
                    "a.exo", [] { std::raise(SIGKILL); }, 10);
              }),
              "a.exo: reading it was stopped by signal 9");
}

TEST(ChildProcess, EndsWhatNeverEnds) {
  volatile bool ever = true;
  EXPECT_FALSE(survives_in_child(
      "a.exo",
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

TEST(NearestName, findsTheSlipAndKeepsSilentOtherwise) {
  const std::vector<std::string> allowed = {"youngs_modulus", "poissons_ratio", "density"};
  EXPECT_EQ(nearest_name("young_modulus", allowed), ", did you mean 'youngs_modulus'?");
  EXPECT_EQ(nearest_name("Density", allowed), ", did you mean 'density'?");
  EXPECT_EQ(nearest_name("temperature", allowed), "");
}

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

TEST(RunThreads, DoesEveryShareOnce) {
  for (const int n : {0, 1, 2, 7}) {
    std::vector<std::atomic<int>> done(7);
    run_threads(n, [&](int t) { ++done[t]; });
    for (int t = 0; t < 7; ++t) EXPECT_EQ(done[t], t < n ? 1 : 0);
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
      run_kept_threads(n, [&](int t) { ++done[t]; });
      for (int t = 0; t < 3; ++t) ASSERT_EQ(done[t], t < n ? 1 : 0);
    }
  });
}

// Each item once, whether the threads are woken for them or not, and an error comes back.
TEST(RowThreads, ItemsAreShared) {
  for (const Index n : {0, 1, 31, 32, 1000}) {
    std::vector<std::atomic<int>> done(static_cast<std::size_t>(n));
    share_among_threads(n, 3, [&](Index i) { ++done[i]; });
    for (const auto& times : done) ASSERT_EQ(times, 1);
  }
  const auto fail = [](Index i) {
    if (i == 500) throw std::runtime_error("item 500");
  };
  EXPECT_THROW(share_among_threads(1000, 3, fail), std::runtime_error);
}

TEST(PhasedWork, AllOfAPhaseIsDoneBeforeTheNextBegins) {
  constexpr std::size_t n_phases = 50, n_pieces = 7;
  std::vector<std::atomic<std::size_t>> done(n_phases);
  std::atomic<int> early = 0;
  PhasedWork work;
  for (std::size_t phase = 0; phase < n_phases; ++phase) {
    work.next_phase();
    for (std::size_t piece = 0; piece < n_pieces; ++piece)
      work.add([&, phase](int) {
        if (phase > 0 && done[phase - 1] % n_pieces != 0) ++early;
        ++done[phase];
      });
  }
  std::size_t runs = 0;
  for (const int n_threads : {1, 2, 3}) {
    for (int round = 0; round < 100; ++round) {
      work.run(n_threads);
      ++runs;
      for (const auto& count : done) ASSERT_EQ(count, runs * n_pieces) << n_threads;
    }
  }
  EXPECT_EQ(early, 0);
}

TEST(PhasedWork, TellsItsPiecesTheThreadThatTheyRunOn) {
  for (const int n_threads : {1, 2, 3}) {
    std::vector<std::atomic<int>> busy(static_cast<std::size_t>(n_threads));
    std::atomic<int> shared = 0;
    PhasedWork work;
    for (int piece = 0; piece < 1000; ++piece)
      work.add([&](int thread) {
        std::atomic<int>& own = busy.at(static_cast<std::size_t>(thread));
        if (++own != 1) ++shared;
        --own;
      });
    work.run(n_threads);
    EXPECT_EQ(shared, 0) << n_threads;
  }
}

TEST(PhasedWork, NothingToDoIsDone) { PhasedWork().run(2); }

}  // namespace
}  // namespace cbr::base_test
