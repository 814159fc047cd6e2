// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/exchange/import/symmetric_entries.hpp"

#include <algorithm>

namespace cbr {

void SymmetricEntries::set(const TextLines& lines, Index i, Index j, double value) {
  char& is_set = is_set_[static_cast<std::size_t>(std::max(i, j) * A_.rows() + std::min(i, j))];
  if (is_set)
    lines.fail("the entry is in the file twice, the other triangle counts too: expected each once");
  is_set = 1;
  A_(i, j) = A_(j, i) = value;
}

}  // namespace cbr
