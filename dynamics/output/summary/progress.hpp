// SPDX-License-Identifier: GPL-3.0-or-later
// Progress of a run while it runs.
#pragma once

#include <functional>
#include <string>

#include "common/app/report.hpp"

namespace cbr {

// On a terminal: a line that is redrawn, with time reached, per cent and time left. In a log: a
// line at every tenth of the run, if the first tenth takes more than a second, and after half a
// minute without one.
class RunProgress {
 public:
  using Seconds = std::function<double()>;  // wall time since an arbitrary origin
  // `what`: "stepping"; `end`: the run's time, s. `from`: fraction done before a restart.
  RunProgress(Report& report, std::string what, double end, double from, bool is_terminal,
              Seconds clock);
  RunProgress(Report& report, std::string what, double end, double from = 0);

  // Fraction of the run's time; `where`: text instead of the time.
  void at(double fraction, const std::string& where = {});

 private:
  std::string left(double fraction, double elapsed) const;

  Report& report_;
  const std::string what_;
  const double end_, from_;
  const bool is_terminal_;
  const Seconds clock_;
  const double begin_;
  double drawn_ = -1, line_at_ = 0;  // of the last drawing and line, seconds since `begin_`
  int told_ = 0;       // tenths reported
};

}  // namespace cbr
