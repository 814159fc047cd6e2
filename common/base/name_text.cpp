// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/name_text.hpp"

#include <map>

#include "common/base/error.hpp"

namespace cbr {
namespace {

// Bytes of the character that begins at `text`, by RFC 3629; 0: it is none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xc2 && first < 0xe0   ? 2
                             : first >= 0xe0 && first < 0xf0 ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  const bool is_too_long = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xf0 && byte(1) < 0x90);
  const bool is_surrogate = first == 0xed && byte(1) >= 0xa0;
  const bool is_beyond = first == 0xf4 && byte(1) >= 0x90;
  return is_too_long || is_surrogate || is_beyond ? 0 : length;
}

}  // namespace

std::string name_problem(std::string_view name) {
  for (std::size_t i = 0; i < name.size();) {
    const auto code = static_cast<unsigned char>(name[i]);
    if (code < 0x20 || code == 0x7f)
      return "holds a control character (code " + std::to_string(code) + ")";
    const std::size_t length = utf8_length(name.substr(i));
    if (length == 0) return "holds bytes that are not UTF-8";
    i += length;
  }
  return "";
}

std::string printable_name(std::string_view name) {
  std::string shown(name.substr(0, 60));
  for (char& c : shown)
    if (c < ' ' || c > '~') c = '?';
  return shown;
}

std::string group_name(std::string name) {
  for (char& c : name)
    if (c == '/') c = '_';
  return name;
}

void refuse_equal_groups(const std::vector<std::string>& names, const std::string& what) {
  std::map<std::string, std::string> groups;
  for (const std::string& name : names) {
    const auto [other, is_new] = groups.emplace(group_name(name), name);
    if (!is_new && other->second != name)
      throw InputError(what + " '" + other->second + "' and '" + name +
                       "' would have one group in the results, where a slash becomes an "
                       "underscore: rename one of them");
  }
}

}  // namespace cbr
