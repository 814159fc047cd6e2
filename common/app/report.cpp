// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/app/report.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/files/checked_files.hpp"
#include "common/files/output_file.hpp"

namespace cbr {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A value or an attribute of a damaged file may be of any length. The fault stands before it,
// the cure behind.
std::string in_short(const std::string& text) {
  constexpr std::size_t longest = 3000, head = 800, tail = 800;
  if (text.size() <= longest) return text;
  const auto inside = [&](std::size_t i) {
    return (static_cast<unsigned char>(text[i]) & 0xc0u) == 0x80u;
  };  // a character of UTF-8
  std::size_t from = head, to = text.size() - tail;
  while (from > 0 && inside(from)) --from;
  while (to < text.size() && inside(to)) ++to;
  return text.substr(0, from) + " ... [" + std::to_string(to - from) + " bytes] ... " +
         text.substr(to);
}

// Names come from the user's files: no control characters to the terminal, and one message stays
// one line.
std::string printable(const std::string& whole) {
  std::string text = in_short(whole);
  for (char& character : text) {
    const auto code = static_cast<unsigned char>(character);
    if (character == '\n' || character == '\t') {
      character = ' ';
    } else if (code < 0x20 || code == 0x7f) {
      character = '?';
    }
  }
  return text;
}

// One write per line, so that the programs of a pipe do not cut into each other's lines.
void print(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

std::string format(const char* pattern, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, pattern, value);
  return buffer;
}

// Names are our own words: no comma, no quote.
std::string table_row(const std::string& kind, const std::string& name, double value) {
  return kind + "," + name + "," + number_text(value) + "\n";
}

constexpr const char* table_header = "kind,name,value";

// A mistyped --timings would cost the user a scene, a mesh or the results. Anything but a regular
// file is refused by who writes it.
void refuse_to_replace(const std::filesystem::path& file) {
  refuse_other_file(file,
                    {.noun = "a table of timings", .start = "^" + std::string(table_header) + "\n"},
                    "the timings", "give --timings another name");
}

void add(std::vector<std::pair<std::string, double>>& sums, const std::string& name,
         double amount) {
  for (auto& [known, sum] : sums) {
    if (known != name) continue;
    sum += amount;
    return;
  }
  sums.emplace_back(name, amount);
}

}  // namespace

Report::Report(std::string program, Verbosity verbosity, std::filesystem::path timings_file)
    : program_(std::move(program)),
      verbosity_(verbosity),
      timings_file_(std::move(timings_file)),
      start_(Clock::now()),
      last_progress_() {
  if (timings_file_.empty()) return;
  refuse_to_replace(timings_file_);
  const TemporaryFile probe(timings_file_);
}

void Report::line(const std::string& text) {
  if (verbosity_ == Verbosity::quiet) return;
  end_progress();
  print(printable(text) + "\n");
}

void Report::detail(const std::string& text) {
  if (verbosity_ == Verbosity::verbose) line(about_ + text);
}

void Report::warning(const std::string& text) {
  const std::string told = printable(about_ + text);
  end_progress();
  warnings_.push_back(told);
  if (std::find(told_before_.begin(), told_before_.end(), told) != told_before_.end()) return;
  print(program_ + ": warning: " + warnings_.back() + "\n");
}

void Report::start_again() {
  told_before_.insert(told_before_.end(), warnings_.begin(), warnings_.end());
  warnings_.clear();
}

void Report::recall(const std::vector<std::string>& warnings) {
  std::vector<std::string> all = warnings;
  for (const std::string& text : warnings_)
    if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(text);
  warnings_ = std::move(all);
}

void Report::progress(const std::string& what, double fraction) {
  const double share = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  if (what != in_work_ || share < first_share_) {
    in_work_ = what;
    first_share_ = share;
    work_start_ = Clock::now();
  }
  std::string text = what + "  " + format("%.0f %%", std::floor(100 * share));
  const double elapsed = seconds_since(work_start_);
  if (elapsed > 2 && share > first_share_)
    text += ", " + human_seconds(elapsed * (1 - share) / (share - first_share_)) + " left";
  draw(text);
}

void Report::draw(const std::string& text) {
  static const bool is_terminal = ::isatty(STDERR_FILENO) == 1;
  if (verbosity_ == Verbosity::quiet || !is_terminal) return;
  const auto now = Clock::now();
  if (in_progress_ && now - last_progress_ < std::chrono::milliseconds(100)) return;
  last_progress_ = now;
  in_progress_ = true;
  print("\r\033[K" + printable(text));
}

void Report::end_progress() {
  if (!in_progress_) return;
  in_progress_ = false;
  print("\r\033[K");
}

Report::Phase::Phase(Report& report, std::string name)
    : report_(report), name_(std::move(name)), start_(Clock::now()) {
  report_.draw(name_);
}

Report::Phase::~Phase() { add(report_.phases_, name_, seconds_since(start_)); }

void Report::count(const std::string& name, double amount) { add(counts_, name, amount); }

void Report::part(const std::string& phase, const std::string& name, double seconds) {
  add(parts_, phase + ": " + name, seconds);
}

double Report::seconds(const std::string& phase) const {
  for (const auto& [name, total] : phases_) {
    if (name == phase) return total;
  }
  return 0;
}

void Report::timings() {
  std::size_t width = 5;
  for (const auto& [name, total] : phases_) width = std::max(width, name.size());
  const double all = seconds_since(start_);
  for (const auto& [name, total] : phases_) {
    line("  " + name + std::string(width - name.size() + 2, ' ') + format("%10.3f s", total) +
         format("%6.1f %%", all > 0 ? 100 * total / all : 0));
    for (const auto& [part, seconds] : parts_) {
      if (part.rfind(name + ": ", 0) == 0)
        detail("    " + part.substr(name.size() + 2) + format(": %.4f s", seconds));
    }
  }
  line("  total" + std::string(width - 5 + 2, ' ') + format("%10.3f s", all) + "  peak memory " +
       human_bytes(peak_memory_bytes()));
}

void Report::write_timings() const {
  if (timings_file_.empty()) return;
  refuse_to_replace(timings_file_);  // the run itself may have written it
  TemporaryFile file(timings_file_);
  std::ofstream out(file.path());
  out << table_header << "\n";
  for (const auto& [name, total] : phases_) out << table_row("phase", name, total);
  out << table_row("phase", "total", seconds_since(start_));
  for (const auto& [name, seconds] : parts_) out << table_row("part", name, seconds);
  for (const auto& [name, sum] : counts_) out << table_row("count", name, sum);
  out << table_row("count", "peak_memory_bytes", peak_memory_bytes());
  out.close();
  if (!out) throw RunError(timings_file_.string() + ": cannot be written: is the disk full?");
  file.commit();
}

void Report::refuse_timings_at(const std::filesystem::path& output, const std::string& what) const {
  if (timings_file_.empty() || !is_same_file(output, timings_file_)) return;
  throw InputError(timings_file_.string() + ": is the file of both " + what +
                   " and the timings: give --timings another name");
}

void print_error(const std::string& program, const std::string& text) {
  print(program + ": error: " + printable(text) + "\n");
}

double peak_memory_bytes() {
  // getrusage's figure is inherited from the process that started this one; the kernel's own
  // high-water mark is not.
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmHWM:", 0) != 0) continue;
    std::istringstream words(line.substr(6));
    double kilobytes = 0;
    if (words >> kilobytes) return 1024 * kilobytes;
  }
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

std::string human_bytes(double bytes) {
  const char* units[] = {"B", "kB", "MB", "GB", "TB", "PB"};
  std::size_t unit = 0;
  // 999.95 would be printed as 1000.0.
  while (std::abs(bytes) >= 999.95 && unit + 1 < std::size(units)) {
    bytes /= 1000;
    ++unit;
  }
  return format(unit == 0 ? "%.0f " : "%.1f ", bytes) + units[unit];
}

std::string human_seconds(double seconds) {
  if (!(std::abs(seconds) < 1e15)) return format("%.3g s", seconds);
  if (seconds < 1e-3) return format("%.3g us", 1e6 * seconds);
  if (seconds < 0.9995) return format("%.3g ms", 1e3 * seconds);
  if (seconds < 59.995) return format("%.2f s", seconds);
  const auto whole = static_cast<long long>(std::llround(seconds));
  const auto two_units = [](long long a, const char* unit_a, long long b, const char* unit_b) {
    return std::to_string(a) + " " + unit_a + " " + std::to_string(b) + " " + unit_b;
  };
  if (whole < 3600) return two_units(whole / 60, "min", whole % 60, "s");
  return two_units(whole / 3600, "h", whole % 3600 / 60, "min");
}

}  // namespace cbr
