// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/app: what the three programs share: arguments, signals, the report.
//
// Options that the three programs share: --help, --version, --quiet, --verbose,
// --threads, --timings, and how they end.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

#include "common/app/report.hpp"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace cbr {

struct CommonOptions {
  bool quiet = false, verbose = false;
  int threads = 0;      // 0: all processors
  std::string timings;  // file, or empty: see Report::write_timings
  Verbosity verbosity() const;
};

void add_common_options(CLI::App& app, CommonOptions& options);

// For an option: "'x' is not a number of threads, give a whole number from 1".
CLI::Validator whole_number(const std::string& of_what, int least);

// Parses, runs `body`, maps the outcome to the exit code: 0 done, 1 RunError or an unexpected
// exception, 2 InputError or usage.
int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& body);

// While one is there, the first SIGINT, SIGTERM or SIGHUP is noted only, for a loop that then ends
// by itself; a second one ends the program as they do else: nothing half-written is left, exit
// code 1. One at a time.
class NotedSignals {
 public:
  NotedSignals();
  ~NotedSignals();
  NotedSignals(const NotedSignals&) = delete;
  NotedSignals& operator=(const NotedSignals&) = delete;
  bool any() const;
  std::string name() const;  // "SIGTERM"
};

// Where a filter hands its scene on: stdout, or null when that is a terminal.
std::ostream* filter_output();

// stdout, for what a command is asked to print, as a table.
std::ostream& table_output();

}  // namespace cbr
