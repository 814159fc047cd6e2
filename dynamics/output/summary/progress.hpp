// SPDX-License-Identifier: GPL-3.0-or-later
// How far a run has come, while it runs.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "common/app/report.hpp"

namespace cbr {

// On a terminal a line that is redrawn: time reached, per cent, time left. In a log a line at every
// tenth of the run, of runs that take longer than a second to the first of them.
class RunProgress {
 public:
  using Seconds = std::function<double()>;  // wall time since any moment
  // `what`: "stepping"; `end`: the run's time, s. `from`: the share of it that a run that goes on
  // has behind it.
  RunProgress(Report& report, std::string what, double end, double from, bool is_terminal,
              Seconds clock);
  RunProgress(Report& report, std::string what, double end, double from = 0);

  // Of the run's time; `where`: in the place of the time.
  void at(double fraction, const std::string& where = {});

 private:
  std::string left(double fraction, double elapsed) const;

  Report& report_;
  const std::string what_;
  const double end_, from_;
  const bool is_terminal_;
  const Seconds clock_;
  const double begin_;
  double drawn_ = -1;  // seconds since `begin_`
  int told_ = 0;       // tenths
};

}  // namespace cbr
