// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "common/base/text_lines.hpp"
#include "common/base/types.hpp"

namespace cbr {

// A symmetric matrix that is filled entry by entry, n x n.
class SymmetricEntries {
 public:
  explicit SymmetricEntries(Index n)
      : A_(Matrix::Zero(n, n)), is_set_(static_cast<std::size_t>(n * n), 0) {}

  // A(i, j) = A(j, i) = value, from 0. InputError at the line: an entry that has been set before.
  void set(const TextLines& lines, Index i, Index j, double value);
  Matrix take() { return std::move(A_); }

 private:
  Matrix A_;
  std::vector<char> is_set_;
};

}  // namespace cbr
