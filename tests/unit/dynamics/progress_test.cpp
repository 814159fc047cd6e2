// SPDX-License-Identifier: GPL-3.0-or-later
// What a run says while it runs.
#include "dynamics/output/summary/progress.hpp"
#include "tests/support/refusal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace cbr::progress_test {
namespace {

// What is printed by a run whose share f of the time takes f * seconds.
std::string printed(bool is_terminal, double seconds, double from = 0,
                    Verbosity verbosity = Verbosity::normal) {
  testing::internal::CaptureStderr();
  double now = 5;
  Report report("cbr-test", verbosity);
  RunProgress progress(report, "stepping", 2e-3, from, is_terminal, [&] { return now; });
  for (int i = static_cast<int>(1000 * from) + 1; i <= 1000; ++i) {
    now = 5 + (i / 1000.0 - from) * seconds;
    progress.at(i / 1000.0);
  }
  report.end_progress();
  return testing::internal::GetCapturedStderr();
}

int lines(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

TEST(RunProgress, ALogGetsALineAtEveryTenth) {
  const std::string text = printed(false, 100);
  EXPECT_EQ(lines(text), 9) << text;
  EXPECT_SAYS(text, "stepping: 10 %, t = 0.0002 s of 0.002 s, 1 min 30 s left\n",
              "stepping: 90 %, t = 0.0018 s of 0.002 s, 10.00 s left\n");
}

TEST(RunProgress, ALongLoadStepSaysItsIterations) {
  testing::internal::CaptureStderr();
  double now = 0;
  Report report("cbr-test", Verbosity::normal);
  RunProgress progress(report, "statics", 1, 0, false, [&] { return now; });
  for (int i = 1; i <= 100; ++i) {
    now = i;
    progress.at(0.25, "load step 2 of 4, iteration " + std::to_string(i));
  }
  report.end_progress();
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(lines(text), 4) << text;  // the tenth at once, then every half minute
  EXPECT_SAYS(text, "statics: 25 %, load step 2 of 4, iteration 32,");
}

TEST(RunProgress, ShortRunsAndQuietOnesSayNothing) {
  EXPECT_EQ(printed(false, 0.9), "");
  EXPECT_EQ(printed(false, 100, 0, Verbosity::quiet), "");
}

TEST(RunProgress, ARunThatGoesOnCountsWhatItHasDone) {
  const std::string text = printed(false, 200, 0.5);
  EXPECT_EQ(lines(text), 4) << text;
  EXPECT_SAYS(text, "stepping: 60 %, t = 0.0012 s of 0.002 s, 1 min 20 s left\n");
}

}  // namespace
}  // namespace cbr::progress_test
