// SPDX-License-Identifier: GPL-3.0-or-later
// Reads numbers from a section of a .msh file. For msh_file.cpp.
#pragma once

#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "common/base/error.hpp"
#include "common/base/types.hpp"

namespace cbr {

// A section's contents: numbers as text, or in binary as the machine that wrote them had them.
struct MshCursor {
  std::string where;  // "block.msh: section $Nodes"
  std::string_view text;
  bool binary = false;

  [[noreturn]] void fail(const std::string& what) const { throw InputError(where + ": " + what); }

  template <class T>
  T number() {
    if (!binary) return text_number<T>();
    T value{};
    if (text.size() < sizeof(T)) fail("is cut short or damaged");
    std::memcpy(&value, text.data(), sizeof(T));
    text.remove_prefix(sizeof(T));
    return value;
  }

  // Also in binary files some numbers are text.
  template <class T>
  T text_number() {
    constexpr std::string_view blanks = " \t\r\n";
    const auto start = text.find_first_not_of(blanks);
    if (start == std::string_view::npos) fail("is cut short: a number is missing at its end");
    text.remove_prefix(start);
    if (text[0] == '+') text.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const auto length = static_cast<std::size_t>(end - text.data());
    if (error == std::errc::result_out_of_range)
      fail("the number '" + std::string(text.substr(0, std::min<std::size_t>(length, 30))) +
           "' is out of range");
    if (error != std::errc() ||
        (length < text.size() && blanks.find(text[length]) == std::string_view::npos))
      fail("a number should stand where '" +
           std::string(text.substr(0, std::min<std::size_t>(text.find_first_of(blanks), 20))) +
           "' stands");
    text.remove_prefix(length);
    return value;
  }

  // How many entries follow; each takes at least a byte.
  std::size_t count() { return bounded(number<std::uint64_t>()); }
  std::size_t text_count() { return bounded(text_number<std::uint64_t>()); }
  std::size_t bounded(std::uint64_t n) const {
    if (n > text.size())
      fail("announces " + std::to_string(n) +
           " entries, more than it can hold: damaged or cut short");
    return static_cast<std::size_t>(n);
  }

  void skip_doubles(std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) number<double>();
  }

  // The rest of the line, and past its end.
  std::string_view line() {
    const auto end = std::min(text.find('\n'), text.size());
    const auto found = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return found;
  }

  void expect_end() const {
    if (!binary && text.find_first_not_of(" \t\r\n") != std::string_view::npos)
      fail("holds more than it announces: damaged");
  }
};

}  // namespace cbr
