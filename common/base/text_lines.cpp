// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/text_lines.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>

#include "common/base/error.hpp"

namespace cbr {
namespace {

// Text for messages of a field that may be a whole binary file.
std::string shown(std::string_view field) {
  return "'" + std::string(field.substr(0, 40)) + (field.size() > 40 ? "..." : "") + "'";
}

}  // namespace

TextLines::TextLines(const std::filesystem::path& file, bool may_end_anywhere)
    : file_(file), may_end_anywhere_(may_end_anywhere) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw InputError(file.string() + ": no such file");
  if (!std::filesystem::is_regular_file(file, error))
    throw InputError(file.string() + ": is not a regular file");
  in_.open(file);
  if (!in_) throw InputError(file.string() + ": cannot be opened: " + std::strerror(errno));
}

bool TextLines::next() {
  if (!std::getline(in_, line_)) {
    if (in_.bad()) throw InputError(file_.string() + ": cannot be read");
    return false;
  }
  ++count_;
  if (count_ == 1) line_ = std::string(without_mark(line_, file_.string()));
  if (in_.eof() && !may_end_anywhere_)
    fail("the last line has no end: the file seems to be cut off, export it again");
  if (!line_.empty() && line_.back() == '\r') line_.pop_back();
  return true;
}

void TextLines::fail(const std::string& what, Index line) const {
  throw InputError(file_.string() + (line > 0 ? ":" + std::to_string(line) : "") + ": " + what);
}

double TextLines::number(std::string_view field) const {
  std::string text(trimmed(field));
  for (char& c : text)
    if (c == 'D' || c == 'd') c = 'E';
  const std::size_t sign = !text.empty() && text[0] == '+' ? 1 : 0;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data() + sign, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    fail(shown(field) + " found, expected a finite number");
  return value;
}

Index TextLines::whole(std::string_view field) const {
  const std::string_view text = trimmed(field);
  Index value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    fail(shown(field) + " found, expected a whole number");
  return value;
}

std::string_view without_mark(std::string_view text, const std::string& file) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    throw InputError(file + ": is UTF-16: save it as UTF-8 (in Excel 'CSV UTF-8')");
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  return text.substr(text.starts_with(mark) ? mark.size() : 0);
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::vector<std::string_view> fields_of(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  if (separator == ' ') line = trimmed(line);
  while (true) {
    const auto end = separator == ' ' ? line.find_first_of(" \t") : line.find(separator);
    fields.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
    if (separator == ' ') line = trimmed(line);
  }
}

}  // namespace cbr
