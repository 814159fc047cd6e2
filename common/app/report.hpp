// SPDX-License-Identifier: GPL-3.0-or-later
// Banner, progress, warnings, timings, summary: the only code that prints. All of it goes to
// stderr.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

enum class Verbosity { quiet, normal, verbose };

class Report {
 public:
  // `timings_file`: of --timings, empty for none. InputError, before the work: no file can
  // be written there, or one is there that is no table of timings.
  Report(std::string program, Verbosity verbosity, std::filesystem::path timings_file = {});

  // The subject of warnings and details from now on, put before them: "component 'block': ". Empty:
  // nothing.
  void about(std::string what) { about_ = std::move(what); }
  const std::string& about() const { return about_; }

  void line(const std::string& text);     // not when quiet
  void detail(const std::string& text);   // --verbose only
  void warning(const std::string& text);  // always; kept
  // All so far, each a line, in the order in which they were given.
  const std::vector<std::string>& warnings() const { return warnings_; }
  // Those of the run that this one continues: kept before the others, not printed again.
  void recall(const std::vector<std::string>& warnings);
  // The work begins anew: warnings so far are no longer kept, and not printed again.
  void start_again();
  int n_warnings() const { return static_cast<int>(warnings_.size()); }

  // "factorisation  42 %, 12 s left": redrawn in place, only when stderr is a terminal and not
  // quiet, at most ten times a second. It gives the time left after two seconds, at the speed so
  // far.
  void progress(const std::string& what, double fraction);
  // The same with a text of the caller's own.
  void draw(const std::string& text);
  void end_progress();

  // Adds the time since construction to `phase` when it goes out of scope.
  class Phase {
   public:
    Phase(Report& report, std::string name);
    ~Phase();
    Phase(const Phase&) = delete;
    Phase& operator=(const Phase&) = delete;

   private:
    Report& report_;
    std::string name_;
    std::chrono::steady_clock::time_point start_;
  };
  Phase phase(std::string name) { return Phase(*this, std::move(name)); }
  double seconds(const std::string& phase) const;  // 0 when there was none

  // What of a phase went into a part of it; named below it, for the file of timings as "PHASE:
  // NAME".
  void part(const std::string& phase, const std::string& name, double seconds);

  // Work that was done, for the file of timings: counted up under this name.
  void count(const std::string& name, double amount);

  // Wall time by phase (when verbose also their parts), total, peak memory.
  void timings();
  // The same and the counts to the file that --timings names, if any (docs/formats.md). InputError
  // as above. RunError when the disk refuses.
  void write_timings() const;
  // InputError when --timings names this file, which the run is to write as `what`. To be asked
  // before the work.
  void refuse_timings_at(const std::filesystem::path& output, const std::string& what) const;

 private:
  std::string program_, about_;
  Verbosity verbosity_;
  std::vector<std::string> warnings_, told_before_;
  bool in_progress_ = false;
  std::string in_work_;     // the last work of progress()
  double first_share_ = 0;  // and how much of that was done, `work_start_`
  std::filesystem::path timings_file_;
  std::vector<std::pair<std::string, double>> phases_, parts_, counts_;
  std::chrono::steady_clock::time_point start_, last_progress_, work_start_;
};

// "PROGRAM: error: TEXT" on one line, as run_program() prints the error that ended the run.
void print_error(const std::string& program, const std::string& text);

double peak_memory_bytes();                 // of this process
std::string human_bytes(double bytes);      // "3.2 GB"
std::string human_seconds(double seconds);  // "1.24 s", "3 min 12 s"

}  // namespace cbr
