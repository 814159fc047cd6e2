// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/app/report.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <thread>

#include "common/base/error.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::report_test {
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
  EXPECT_SAYS(testing::internal::GetCapturedStderr(), "sleeping", "peak memory");
}

// kind,name -> value of a file of timings
std::map<std::string, double> read_table(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "kind,name,value");
  std::map<std::string, double> table;
  while (std::getline(in, line)) {
    const auto comma = line.rfind(',');
    EXPECT_TRUE(table.emplace(line.substr(0, comma), std::stod(line.substr(comma + 1))).second)
        << line;
  }
  return table;
}

TEST(Report, timingsGoToAFile) {
  const test::TemporaryFolder folder;
  const auto file = folder / "timings.csv";
  Report report("cbr-test", Verbosity::quiet, file);
  for (const char* name : {"sleeping", "waiting", "sleeping"}) {
    const auto phase = report.phase(name);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  report.part("sleeping", "dreams", 1e-3);
  report.count("steps", 3);
  report.count("steps", 0.5);
  EXPECT_FALSE(std::filesystem::exists(file));  // nothing before the end
  report.write_timings();
  const auto table = read_table(file);
  EXPECT_EQ(table.at("phase,sleeping"), report.seconds("sleeping"));
  EXPECT_GE(table.at("phase,total"), table.at("phase,sleeping") + table.at("phase,waiting"));
  EXPECT_EQ(table.at("part,sleeping: dreams"), 1e-3);
  EXPECT_EQ(table.at("count,steps"), 3.5);
  EXPECT_GT(table.at("count,peak_memory_bytes"), 1e6);
  EXPECT_EQ(table.size(), 6u);
  Report("cbr-test", Verbosity::quiet).write_timings();  // to no file: nothing
  EXPECT_EQ(folder.n_entries(), 1u);
}

TEST(Report, timingsThatCannotBeWrittenAreSaidAtTheStart) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(Report("cbr-test", Verbosity::quiet, folder / "missing" / "timings.csv"),
               InputError);
}

TEST(Report, timingsReplaceNothingButTimings) {
  const test::TemporaryFolder folder;
  const auto scene = folder / "impact.yaml", timings = folder / "timings.csv";
  test::write_bytes(scene, "materials: {}\n");
  EXPECT_THROW(Report("cbr-test", Verbosity::quiet, scene), InputError);
  for (int i = 0; i < 2; ++i) Report("cbr-test", Verbosity::quiet, timings).write_timings();
  Report report("cbr-test", Verbosity::quiet, folder / "results.h5");
  test::write_bytes(folder / "results.h5", "results\n");  // of the run itself
  EXPECT_THROW(report.write_timings(), InputError);
  EXPECT_EQ(test::bytes_of(folder / "results.h5") + test::bytes_of(scene),
            "results\nmaterials: {}\n");
}

TEST(Report, timingsGoToNoPipeAndToNoDevice) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const std::filesystem::path& file : {folder / "pipe", std::filesystem::path("/dev/zero")})
    EXPECT_THROW(Report("cbr-test", Verbosity::quiet, file), InputError) << file;
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
}  // namespace cbr::report_test
