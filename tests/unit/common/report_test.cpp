// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/report.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace cbr {
namespace {

std::string printed(Verbosity verbosity) {
  testing::internal::CaptureStderr();
  Report report("cbr-test", verbosity);
  report.progress("reading", 0.5);  // not a terminal: silent
  report.line("a line");
  report.detail("a detail");
  report.warning("a \x1b warning");
  report.end_progress();
  EXPECT_EQ(report.n_warnings(), 1);
  return testing::internal::GetCapturedStderr();
}

TEST(Report, verbosityDecidesWhatIsPrinted) {
  EXPECT_EQ(printed(Verbosity::quiet), "cbr-test: warning: a ? warning\n");
  EXPECT_EQ(printed(Verbosity::normal), "a line\ncbr-test: warning: a ? warning\n");
  EXPECT_EQ(printed(Verbosity::verbose), "a line\na detail\ncbr-test: warning: a ? warning\n");
}

TEST(Report, phasesAddUp) {
  testing::internal::CaptureStderr();
  Report report("cbr-test", Verbosity::normal);
  for (int i = 0; i < 2; ++i) {
    const auto phase = report.phase("sleeping");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_GE(report.seconds("sleeping"), 0.02);
  EXPECT_EQ(report.seconds("working"), 0);
  report.timings();
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_NE(text.find("sleeping"), std::string::npos);
  EXPECT_NE(text.find("peak memory"), std::string::npos);
}

TEST(Report, memoryIsThatOfThisProcess) {
  const double before = peak_memory_bytes();
  EXPECT_GT(before, 1e6);
  const std::vector<char> block(std::size_t{64} << 20, 'x');
  EXPECT_GT(peak_memory_bytes(), 64e6 + 0 * static_cast<double>(block[5]));
}

TEST(Human, bytesAndSeconds) {
  EXPECT_EQ(human_bytes(0), "0 B");
  EXPECT_EQ(human_bytes(999), "999 B");
  EXPECT_EQ(human_bytes(3.2e9), "3.2 GB");
  EXPECT_EQ(human_bytes(999.96e6), "1.0 GB");
  EXPECT_EQ(human_bytes(5e18), "5000.0 PB");
  EXPECT_EQ(human_seconds(1.24), "1.24 s");
  EXPECT_EQ(human_seconds(192), "3 min 12 s");
  EXPECT_EQ(human_seconds(59.999), "1 min 0 s");
  EXPECT_EQ(human_seconds(3725), "1 h 2 min");
  EXPECT_EQ(human_seconds(0.0125), "12.5 ms");
  EXPECT_EQ(human_seconds(3e-6), "3 us");
}

}  // namespace
}  // namespace cbr
