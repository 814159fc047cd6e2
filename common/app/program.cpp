// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/app/program.hpp"

#include <pthread.h>
#include <unistd.h>

#include <CLI/CLI.hpp>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <new>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/files/output_file.hpp"
#include "common/linalg/blas_threads.hpp"

namespace cbr {
namespace {

const char* signal_name(int number) {
  return number == SIGINT    ? "SIGINT"
         : number == SIGTERM ? "SIGTERM"
         : number == SIGHUP  ? "SIGHUP"
                             : "a signal";
}

// Data that a handler may read.
volatile std::sig_atomic_t is_noting = 0, noted = 0;
char name_for_handler[64] = "cbr";

void write_from_handler(const char* text) {
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, std::strlen(text));
}

// A handler runs on the thread that the program began with: were it on one of BLAS's, that one
// would go on and make new files.
pthread_t first_thread;

bool is_handed_on(int number) {
  if (::pthread_equal(::pthread_self(), first_thread)) return false;
  ::pthread_kill(first_thread, number);
  return true;
}

extern "C" void end_by_signal(int number) {
  if (is_handed_on(number)) return;
  if (is_noting && noted == 0) {
    noted = number;
    return;
  }
  remove_temporary_files();
  if (::isatty(STDERR_FILENO) == 1) write_from_handler("\n");  // after progress and "^C"
  write_from_handler(name_for_handler);
  write_from_handler(": error: stopped by ");
  write_from_handler(signal_name(number));
  write_from_handler("; incomplete output files were removed\n");
  ::_exit(1);
}

extern "C" void end_quietly(int number) {
  if (is_handed_on(number)) return;
  remove_temporary_files();
  ::_exit(1);
}

void install_handlers() {
  first_thread = ::pthread_self();
  struct sigaction action = {}, before = {};
  // one at a time
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) sigaddset(&action.sa_mask, number);
  action.sa_flags = SA_RESTART;
  action.sa_handler = end_by_signal;
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    // nohup and a shell's background jobs ask that a signal be ignored.
    if (::sigaction(number, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
      ::sigaction(number, &action, nullptr);
  }
  action.sa_handler = end_quietly;
  ::sigaction(SIGPIPE, &action, nullptr);  // who reads our scene has gone: nothing is left to do
  // a write over the size limit then fails with a message of its own
  std::signal(SIGXFSZ, SIG_IGN);
}

std::string program_name(const CLI::App& app, int argc, char** argv) {
  if (!app.get_name().empty()) return app.get_name();
  return argc > 0 ? std::filesystem::path(argv[0]).filename().string() : "cbr";
}

// Long names of the options, those of option groups included.
void collect_options(const CLI::App& app, std::vector<std::string>& names) {
  for (const auto* option : app.get_options()) {
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  }
  for (const auto* group : app.get_subcommands([](const CLI::App*) { return true; }))
    collect_options(*group, names);
}

// CLI11 lists what it did not expect backwards, with what an unknown option pushed out of its
// place.
std::string usage_text(const CLI::App& app, const CLI::Error& error) {
  if (error.get_exit_code() != static_cast<int>(CLI::ExitCodes::ExtrasError)) return error.what();
  std::vector<std::string> names;
  collect_options(app, names);
  const auto remaining = app.remaining(true);
  for (const auto& argument : remaining) {
    if (argument.size() < 2 || argument[0] != '-') continue;
    const std::string option = argument.substr(0, argument.find('='));
    return "unknown option '" + option + "'" + nearest_name(option, names);
  }
  return error.what();
}

// No argument of ours means anything when it is empty: a variable of the shell that is not set must
// not begin a run anew.
std::string empty_argument(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string text = argv[i];
    if (text.empty())
      return i > 1 ? "the argument after '" + std::string(argv[i - 1]) + "'" : "the first argument";
    if (text.starts_with("--") && text.ends_with("=")) return "what should follow '" + text + "'";
  }
  return "";
}

// "" or an option whose value looks like another option: "--timings --force" names no file.
std::string option_without_value(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options())
    for (const std::string& value : option->results())
      if (option->nonpositional() && option->get_items_expected_max() > 0 &&
          value.starts_with("--"))
        return option->get_name() + ": " + option->get_type_name() + " missing before '" + value +
               "'";
  return "";
}

int usage_error(const CLI::App& app, const CLI::Error& error, const std::string& program) {
  print_error(program, usage_text(app, error) + "; " + program + " --help shows the usage");
  return 2;
}

// Help, version and a filter's scene go to stdout: not written is not done.
int finish(const std::string& program, int code) {
  errno = 0;
  std::cout.flush();
  const bool failed = !std::cout || std::fflush(stdout) != 0;
  if (code != 0 || !failed) return code;
  print_error(program, std::string("standard output cannot be written") +
                           (errno != 0 ? ": " + std::string(std::strerror(errno)) : ""));
  return 1;
}

int run_body(const std::string& program, const std::function<void()>& body) {
  try {
    body();
    return 0;
  } catch (const InputError& error) {
    print_error(program, error.what());
    return 2;
  } catch (const RunError& error) {
    print_error(program, error.what());
  } catch (const std::bad_alloc&) {
    print_error(program, "out of memory (peak " + human_bytes(peak_memory_bytes()) +
                             "): ask for less or use a larger machine");
  } catch (const std::exception& error) {
    print_error(program, std::string("unexpected: ") + error.what());
  } catch (...) {
    print_error(program, "unexpected: an exception of unknown type");
  }
  return 1;
}

}  // namespace

Verbosity CommonOptions::verbosity() const {
  if (quiet) return Verbosity::quiet;
  return verbose ? Verbosity::verbose : Verbosity::normal;
}

CLI::Validator whole_number(const std::string& of_what, int least) {
  return CLI::Validator(
      [of_what, least](std::string& text) {
        int n = 0;
        if (CLI::detail::lexical_cast(text, n) && n >= least) return std::string();
        return "'" + text + "' is not a number of " + of_what + ", give a whole number from " +
               std::to_string(least);
      },
      "");
}

void add_common_options(CLI::App& app, CommonOptions& options) {
  app.set_version_flag("--version", app.get_name() + " " + version());
  auto* quiet = app.add_flag("-q,--quiet", options.quiet, "Print warnings and errors only");
  app.add_flag("-v,--verbose", options.verbose, "Print details")->excludes(quiet);
  app.add_option("--threads", options.threads,
                 "Maximum number of threads (default: all processors)")
      ->type_name("N")
      ->check(whole_number("threads", 1));
  app.add_option("--timings", options.timings,
                 "Write seconds and work counts of each phase to this CSV file")
      ->type_name("FILE");
  app.parse_complete_callback([&options] { set_threads(options.threads); });
}

int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& body) {
  const std::string program = program_name(app, argc, argv);
  name_for_handler[program.copy(name_for_handler, sizeof name_for_handler - 1)] = '\0';
  install_handlers();
  const std::string empty = empty_argument(argc, argv);
  if (!empty.empty()) {
    print_error(program, empty + " is empty: is a variable of the shell not set? " + program +
                             " --help shows the usage");
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Error& error) {
    if (error.get_exit_code() != 0) return usage_error(app, error, program);
    app.exit(error);  // --help, --version
    return finish(program, 0);
  }
  if (const std::string wrong = option_without_value(app); !wrong.empty()) {
    print_error(program, wrong + "; " + program + " --help shows the usage");
    return 2;
  }
  if (const std::string no_room = reserve_blas_memory(); !no_room.empty()) {
    print_error(program, no_room);
    std::_Exit(1);
  }
  return finish(program, run_body(program, body));
}

NotedSignals::NotedSignals() {
  noted = 0;
  is_noting = 1;
}
NotedSignals::~NotedSignals() { is_noting = 0; }
bool NotedSignals::any() const { return noted != 0; }
std::string NotedSignals::name() const { return signal_name(noted); }

std::ostream* filter_output() { return ::isatty(STDOUT_FILENO) == 1 ? nullptr : &std::cout; }

std::ostream& table_output() { return std::cout; }

}  // namespace cbr
