// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/app/program.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>
#include <new>

#include "common/base/error.hpp"
#include "common/files/output_file.hpp"
#include "common/linalg/blas_threads.hpp"
#include "tests/formats/temporary_folder.hpp"

namespace cbr::program_test {
namespace {

using testing::ExitedWithCode;
using testing::KilledBySignal;

// A program of one option, in the process of a death test.
[[noreturn]] void run(std::vector<std::string> arguments, const std::function<void()>& body) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP})
    std::signal(number, SIG_DFL);  // nohup, and shells' background jobs, ignore some
  CLI::App app("what it does", "cbr-test");
  CommonOptions options;
  Index modes = 0;
  app.add_option("--modes", modes, "how many");
  app.add_option_group("group")->add_option("--depth", modes, "how deep");
  add_common_options(app, options);
  arguments.insert(arguments.begin(), "cbr-test");
  std::vector<char*> argv;
  for (auto& argument : arguments) argv.push_back(argument.data());
  std::exit(run_program(app, static_cast<int>(argv.size()), argv.data(), body));
}

void nothing() {}

TEST(ProgramDeathTest, outcomeIsTheExitCode) {
  EXPECT_EXIT(run({}, nothing), ExitedWithCode(0), "^$");
  EXPECT_EXIT(run({}, [] { throw InputError("a.yaml:3: x: wrong"); }), ExitedWithCode(2),
              "^cbr-test: error: a.yaml:3: x: wrong\n$");
  EXPECT_EXIT(run({}, [] { throw RunError("disk full"); }), ExitedWithCode(1),
              "^cbr-test: error: disk full\n$");
  EXPECT_EXIT(run({}, [] { throw std::bad_alloc(); }), ExitedWithCode(1),
              "^cbr-test: error: out of memory");
  EXPECT_EXIT(run({}, [] { throw std::logic_error("bug"); }), ExitedWithCode(1),
              "^cbr-test: error: unexpected: bug\n$");
  EXPECT_EXIT(run({}, [] { throw 5; }), ExitedWithCode(1), "^cbr-test: error: unexpected");
  // However long the value is that is wrong
  EXPECT_EXIT(
      run({},
          [] {
            throw InputError("a.yaml:3: '" + std::string(70000, 'y') + "' found: give a number");
          }),
      ExitedWithCode(2),
      "^cbr-test: error: a.yaml:3: 'y{780,800} ... .68[0-9]+ bytes. ... y{700,800}' found: give a "
      "number\n$");
  EXPECT_EXIT(run({}, [] { throw InputError("two\nlines\x1b[31m"); }), ExitedWithCode(2),
              "^cbr-test: error: two lines.\\[31m\n$");
}

TEST(ProgramDeathTest, usage) {
  const auto must_not_run = [] { throw RunError("the body ran"); };
  EXPECT_EXIT(run({"--help"}, must_not_run), ExitedWithCode(0), "^$");
  EXPECT_EXIT(run({"--version"}, must_not_run), ExitedWithCode(0), "^$");
  EXPECT_EXIT(run({"--mode", "3"}, must_not_run), ExitedWithCode(2),
              "unknown option '--mode', did you mean '--modes'\\?; cbr-test --help");
  EXPECT_EXIT(run({"--modes", ""}, must_not_run), ExitedWithCode(2),
              "the argument after '--modes' is empty: is a variable of the shell not set\\? "
              "cbr-test --help");
  EXPECT_EXIT(run({"--modes="}, must_not_run), ExitedWithCode(2),
              "what should follow '--modes=' is empty");
  EXPECT_EXIT(run({""}, must_not_run), ExitedWithCode(2), "the first argument is empty");
  EXPECT_EXIT(run({"--dept=3"}, must_not_run), ExitedWithCode(2),
              "unknown option '--dept', did you mean '--depth'\\?");
  EXPECT_EXIT(run({"word"}, must_not_run), ExitedWithCode(2), "not expected: word");
  EXPECT_EXIT(run({"--modes", "many"}, must_not_run), ExitedWithCode(2), "--modes");
  EXPECT_EXIT(run({"--modes"}, must_not_run), ExitedWithCode(2), "--modes");
  EXPECT_EXIT(run({"--timings", "--force"}, must_not_run), ExitedWithCode(2),
              "--timings: FILE missing before '--force'; cbr-test --help shows the usage");
  EXPECT_EXIT(run({"--quiet", "--verbose"}, must_not_run), ExitedWithCode(2), "--quiet");
  for (const char* threads : {"0", "-1", "two", "1.5", "99999999999"}) {
    EXPECT_EXIT(run({"--threads", threads}, must_not_run), ExitedWithCode(2),
                "--threads.*whole number from 1")
        << threads;
  }
}

TEST(ProgramDeathTest, threadsAreBounded) {
  EXPECT_EXIT(run({"--threads", "1"}, [] { throw RunError("n = " + std::to_string(n_threads())); }),
              ExitedWithCode(1), "n = 1\n");
  // More threads than a system starts ended the program without a message.
  set_threads(2000000000);
  EXPECT_LE(n_threads(), 1000);
  set_threads(0);
  EXPECT_GE(n_threads(), 1);
}

TEST(ProgramDeathTest, standardOutputThatCannotBeWritten) {
  const auto print_to = [](const char* file) {
    ::dup2(::open(file, O_WRONLY), STDOUT_FILENO);
    run({}, [] { std::cout << "a scene\n"; });
  };
  EXPECT_EXIT(print_to("/dev/full"), ExitedWithCode(1),
              "standard output cannot be written: No space left");
  EXPECT_EXIT(print_to("/dev/null"), ExitedWithCode(0), "^$");
  const auto print_to_nobody = [] {
    int ends[2];
    if (::pipe(ends) != 0) std::abort();
    ::close(ends[0]);
    ::dup2(ends[1], STDOUT_FILENO);
    run({}, [] { std::cout << "a scene\n" << std::flush; });
  };
  EXPECT_EXIT(print_to_nobody(), ExitedWithCode(1), "^$");
}

TEST(ProgramDeathTest, signalsLeaveNoTemporaryFile) {
  const test::TemporaryFolder folder;
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    const auto interrupted = [&] {
      run({}, [&] {
        const TemporaryFile first(folder / "a.h5"), second(folder / "b.h5");
        std::raise(number);
      });
    };
    EXPECT_EXIT(interrupted(), ExitedWithCode(1), "error: stopped by SIG");
    EXPECT_EQ(folder.n_entries(), 0u);
  }
}

TEST(ProgramDeathTest, theFirstOfTheNotedSignalsIsTheLoopsToHeed) {
  const test::TemporaryFolder folder;
  const auto heeded = [&] {
    run({}, [&] {
      const TemporaryFile file(folder / "a.h5");
      const NotedSignals signals;
      if (signals.any()) throw InputError("too early");
      std::raise(SIGTERM);
      throw RunError(signals.any() ? "noted " + signals.name() : "not noted");
    });
  };
  EXPECT_EXIT(heeded(), ExitedWithCode(1), "noted SIGTERM");
  const auto twice = [&] {
    run({}, [&] {
      const TemporaryFile file(folder / "a.h5");
      const NotedSignals signals;
      std::raise(SIGTERM);
      std::raise(SIGINT);
    });
  };
  EXPECT_EXIT(twice(), ExitedWithCode(1), "error: stopped by SIGINT");
  const auto after = [&] {
    run({}, [&] {
      { const NotedSignals signals; }
      std::raise(SIGHUP);
    });
  };
  EXPECT_EXIT(after(), ExitedWithCode(1), "error: stopped by SIGHUP");
  EXPECT_EQ(folder.n_entries(), 0u);
}

TEST(TemporaryFile, appearsWhenWhole) {
  const test::TemporaryFolder folder;
  {
    TemporaryFile file(folder / "a.txt"), other(folder / "a.txt");
    EXPECT_NE(file.path(), other.path());
    test::write_bytes(file.path(), "new");
    EXPECT_FALSE(std::filesystem::exists(folder / "a.txt"));
    file.commit();
    EXPECT_EQ(test::bytes_of(folder / "a.txt"), "new");
  }
  EXPECT_EQ(folder.n_entries(), 1u);
}

}  // namespace
}  // namespace cbr::program_test
