// SPDX-License-Identifier: GPL-3.0-or-later
// Text files of other codes, line by line, with messages that name the line.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "common/types.hpp"

namespace cbr {

class TextLines {
 public:
  // InputError: the file cannot be opened, or is no regular file.
  explicit TextLines(const std::filesystem::path& file);

  // The next line without its end; false after the last one. InputError: a last line without an end, which may be cut off.
  bool next();
  const std::string& line() const { return line_; }
  // InputError "FILE:LINE: what".
  [[noreturn]] void fail(const std::string& what) const;

  // InputError unless the field, without the blanks around it, is a finite number, or a whole one. D marks an exponent, too.
  double number(std::string_view field) const;
  Index whole(std::string_view field) const;

 private:
  std::filesystem::path file_;
  std::ifstream in_;
  std::string line_;
  Index count_ = 0;
};

std::string_view trimmed(std::string_view text);
// Parts between `separator`s, trimmed. Between blanks: ' ', of which many count as one.
std::vector<std::string_view> fields_of(std::string_view line, char separator);

// A symmetric matrix that is filled entry by entry, n x n.
class SymmetricEntries {
 public:
  explicit SymmetricEntries(Index n) : A_(Matrix::Zero(n, n)), is_set_(static_cast<std::size_t>(n * n), 0) {}

  // A(i, j) = A(j, i) = value, from 0. InputError at the line: an entry that has been set before.
  void set(const TextLines& lines, Index i, Index j, double value);
  Matrix take() { return std::move(A_); }

 private:
  Matrix A_;
  std::vector<char> is_set_;
};

}  // namespace cbr
