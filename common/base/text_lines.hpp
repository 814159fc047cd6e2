// SPDX-License-Identifier: GPL-3.0-or-later
// Text files of other codes, line by line, with messages that name the line.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

class TextLines {
 public:
  // InputError: the file cannot be opened, or is no regular file. `may_end_anywhere`: a last line
  // without an end is no error; such a file may have been cut off, so only for formats that people
  // write by hand.
  explicit TextLines(const std::filesystem::path& file, bool may_end_anywhere = false);

  // The next line without its end; false after the last one. InputError: a last line without an
  // end.
  bool next();
  const std::string& line() const { return line_; }
  Index count() const { return count_; }  // number of that line, from 1
  // InputError "FILE:LINE: what".
  [[noreturn]] void fail(const std::string& what) const { fail(what, count_); }
  [[noreturn]] void fail(const std::string& what, Index line) const;

  // InputError unless the field, without the blanks around it, is a finite number, or a whole one.
  // D marks an exponent, too.
  double number(std::string_view field) const;
  Index whole(std::string_view field) const;

 private:
  std::filesystem::path file_;
  bool may_end_anywhere_;
  std::ifstream in_;
  std::string line_;
  Index count_ = 0;
};

// The beginning of a file without UTF-8's byte order mark, which Excel and some editors write.
// InputError: UTF-16, by its mark.
std::string_view without_mark(std::string_view text, const std::string& file);
std::string_view trimmed(std::string_view text);
// Parts between `separator`s, trimmed. Between blanks: ' ', of which many count as one.
std::vector<std::string_view> fields_of(std::string_view line, char separator);

}  // namespace cbr
