// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <charconv>
#include <cstdio>
#include <string>

namespace cbr {

// The text of std::snprintf, at most 319 characters.
template <typename... Values>
std::string format_text(const char* pattern, Values... values) {
  char text[320];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

// The shortest decimal text that reads back as the same double, whatever the locale.
inline std::string number_text(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

}  // namespace cbr
