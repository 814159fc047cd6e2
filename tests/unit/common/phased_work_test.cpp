// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/phased_work.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace cbr::phased_work_test {
namespace {

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
}  // namespace cbr::phased_work_test
