// SPDX-License-Identifier: GPL-3.0-or-later
// How a load changes in time: a table, a CSV file, a sine.
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/base/text_lines.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

// Straight lines between so many points of a period are off by 1 - cos(pi / n), 1.2e-4, of the
// amplitude at most.
constexpr double points_per_period = 200;
constexpr double most_points = 1e6;

History parse_table(const SceneMap& map) {
  History history{map.at("time").numbers(), map.at("value").numbers()};
  if (history.time.empty()) map.at("time").fail("is empty, expected at least one time");
  if (history.time.size() != history.value.size()) {
    map.at("value").fail(
        "has " + std::to_string(history.value.size()) +
        " entries, expected as many as 'time' has: " + std::to_string(history.time.size()));
  }
  for (std::size_t i = 1; i < history.time.size(); ++i) {
    if (history.time[i] <= history.time[i - 1])
      map.at("time").list()[i].fail("not above the time before it, times must ascend");
  }
  return history;
}

// The first two numbers of a line, between commas, semicolons or spaces; whether there are two and
// nothing else.
bool two_numbers(std::string_view line, double (&value)[2]) {
  constexpr std::string_view between = ",; \t\r";
  for (double& number : value) {
    const std::size_t first = line.find_first_not_of(between);
    if (first == std::string_view::npos) return false;
    line.remove_prefix(first);
    if (line.front() == '+') line.remove_prefix(1);
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
    if (error != std::errc() || !std::isfinite(number)) return false;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    if (!line.empty() && between.find(line.front()) == std::string_view::npos) return false;
  }
  return line.find_first_not_of(between) == std::string_view::npos;
}

// Lines of time and value. A first line of names, empty lines, and lines that begin with # are
// passed over.
History read_csv(const std::filesystem::path& file) {
  TextLines lines(file, true);
  History history;
  bool is_first = true;
  while (lines.next()) {
    const std::string_view line = trimmed(lines.line());
    if (line.empty() || line.front() == '#') continue;
    double value[2];
    const bool is_row = two_numbers(line, value);
    const bool is_header =
        is_first && !is_row && std::isalpha(static_cast<unsigned char>(line.front())) != 0;
    is_first = false;
    if (is_header) continue;
    if (!is_row)
      lines.fail("found '" + std::string(line.substr(0, 60)) + "', expected a time and a value");
    if (!history.time.empty() && value[0] <= history.time.back())
      lines.fail("not above the time before it, times must ascend");
    history.time.push_back(value[0]);
    history.value.push_back(value[1]);
  }
  if (history.time.empty()) lines.fail("has no line of a time and a value", 0);
  return history;
}

History read_csv(const std::filesystem::path& file, const SceneNode& node) {
  try {
    return read_csv(file);
  } catch (const InputError& error) {
    node.fail(error.what());
  }
}

// sin(2 pi f (t - start) + phase) from `start` for so many cycles, or to the end of the run; 0
// before and after.
History sample_sine(const SceneNode& node, const SceneReading& reading) {
  double frequency = 0, degrees = 0, start = 0;
  std::optional<double> given;
  read_keys(node,
            {{"frequency_hz", Number{frequency, positive}, true, true},
             {"phase", Number{degrees}},
             {"start", Number{start, not_negative}},
             {"cycles", Number{given, positive}}},
            reading);
  const double phase = degrees * std::numbers::pi / 180;
  const std::optional<TimeOptions>& time = reading.scene.time;
  if (!given && !time) node.fail("needs 'cycles' in a scene that has no 'time'");
  const double cycles = given ? *given : std::max(0.0, (time->end - start) * frequency) + 1;
  const double n = std::ceil(cycles * points_per_period);
  if (n > most_points)
    node.fail("is of more than 5000 cycles: give 'cycles', a shorter run, or a lower frequency");
  History history;
  const auto add = [&](double time, double value) {
    if (!history.time.empty() && time <= history.time.back()) return;
    history.time.push_back(time);
    history.value.push_back(value);
  };
  const auto count = static_cast<int>(n);
  const double jump = 1e-9 / frequency;
  if (start > jump && std::sin(phase) != 0) add(start - jump, 0);
  for (int i = 0; i <= count; ++i) {
    const double cycle = cycles * i / count;
    add(start + cycle / frequency, std::sin(2 * std::numbers::pi * cycle + phase));
  }
  if (given) add(start + cycles / frequency + jump, 0);
  return history;
}

}  // namespace

void read_history(const SceneNode& node, const SceneReading& reading, History& history) {
  const SceneMap map = node.map({"time", "value", "file", "sine"});
  const SceneNode *file = map.find("file"), *sine = map.find("sine");
  if ((file != nullptr || sine != nullptr) && map.entries().size() > 1)
    node.fail(std::string(file != nullptr ? "'file'" : "'sine'") +
              " stands alone: remove the other keys");
  history = file != nullptr   ? read_csv(resolve_path(*file, reading.folder), *file)
            : sine != nullptr ? sample_sine(*sine, reading)
                              : parse_table(map);
}

void read_force_table(const SceneNode& node, ForceTable& table) {
  for (const SceneNode& row : node.list()) {
    const std::vector<double> pair = row.numbers();
    if (pair.size() != 2)
      row.fail("has " + std::to_string(pair.size()) + " numbers, expected two: [x, force]");
    if (!table.empty() && !(pair[0] > table.at.back()))
      row.fail("does not ascend: expected an x above " + number_text(table.at.back()));
    if (!table.empty() && pair[1] < table.force.back())
      row.fail("falls below the force before it, which has no one answer: expected at least " +
               number_text(table.force.back()));
    table.at.push_back(pair[0]);
    table.force.push_back(pair[1]);
  }
  if (table.at.size() < 2) node.fail("expected at least two rows [x, force]");
}

std::string force_table_text(const ForceTable& table) {
  std::vector<std::string> rows;
  for (std::size_t i = 0; i < table.at.size(); ++i)
    rows.push_back(yaml_numbers({table.at[i], table.force[i]}));
  return table.empty() ? "" : yaml_list(rows);
}

std::string history_text(const History& history) {
  if (history.time.empty()) return "";
  return "{time: " + yaml_numbers(history.time) + ", value: " + yaml_numbers(history.value) + "}";
}

}  // namespace cbr
