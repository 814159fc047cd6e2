// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/summary/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/format_text.hpp"

namespace cbr {
namespace {

constexpr double between_drawings = 0.1, first_line = 1, longest_silence = 30;  // seconds

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

RunProgress::RunProgress(Report& report, std::string what, double end, double from,
                         bool is_terminal, Seconds clock)
    : report_(report),
      what_(std::move(what)),
      end_(end),
      from_(from),
      is_terminal_(is_terminal),
      clock_(std::move(clock)),
      begin_(clock_()),
      told_(static_cast<int>(10 * from)) {}

RunProgress::RunProgress(Report& report, std::string what, double end, double from)
    : RunProgress(report, std::move(what), end, from, ::isatty(STDERR_FILENO) == 1,
                  steady_seconds) {}

// Remaining time, in proportion to the elapsed time.
std::string RunProgress::left(double fraction, double elapsed) const {
  if (!(fraction > from_)) return "";
  return ", " + human_seconds(elapsed * (1 - fraction) / (fraction - from_)) + " left";
}

void RunProgress::at(double fraction, const std::string& where) {
  if (!std::isfinite(fraction)) return;
  const std::string reached =
      where.empty() ? format_text("t = %.4g s of %.4g s", fraction * end_, end_) : where;
  const double elapsed = clock_() - begin_;
  if (is_terminal_) {
    if (drawn_ >= 0 && elapsed - drawn_ < between_drawings) return;
    drawn_ = elapsed;
    report_.draw(what_ + format_text(": %.0f %%, ", std::floor(100 * fraction)) + reached +
                 left(fraction, elapsed));
    return;
  }
  const int tenths = static_cast<int>(std::floor(10 * fraction + 1e-9));
  const bool is_silent = elapsed - line_at_ > longest_silence;
  if ((tenths <= told_ && !is_silent) || tenths >= 10) return;
  told_ = std::max(told_, tenths);
  if (elapsed < first_line) return;
  line_at_ = elapsed;
  report_.line(what_ + format_text(": %.0f %%, ", std::floor(100 * fraction + 1e-9)) + reached +
               left(fraction, elapsed));
}

}  // namespace cbr
