// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/process.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "common/base/error.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::child_process_test {
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

}  // namespace
}  // namespace cbr::child_process_test
