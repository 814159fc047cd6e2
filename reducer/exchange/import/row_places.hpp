// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of matrices by the node and dof that formats name them with, and their entries.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/text_lines.hpp"
#include "common/base/types.hpp"
#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {

class RowPlaces {
 public:
  // modal_dof: the format's dof of a modal coordinate.
  RowPlaces(const std::vector<ReducedRow>& rows, int modal_dof) {
    for (const ReducedRow& row : rows)
      places_.emplace(std::pair(row.node, Index{row.dof == 0 ? modal_dof : row.dof}),
                      static_cast<Index>(places_.size()));
  }

  // InputError at the line: no row of this node and dof.
  Index place(const TextLines& lines, Index node, Index dof) const {
    const auto found = places_.find({node, dof});
    if (found == places_.end())
      lines.fail("dof " + std::to_string(dof) + " of node " + std::to_string(node) +
                 " is not in the table beside the file");
    return found->second;
  }

 private:
  std::map<std::pair<Index, Index>, Index> places_;
};

// A symmetric matrix that is filled entry by entry, n x n.
class SymmetricEntries {
 public:
  explicit SymmetricEntries(Index n)
      : A_(Matrix::Zero(n, n)), is_set_(static_cast<std::size_t>(n * n), 0) {}

  // A(i, j) = A(j, i) = value, from 0. InputError at the line: an entry that has been set before.
  void set(const TextLines& lines, Index i, Index j, double value) {
    char& is_set = is_set_[std::max(i, j) * A_.rows() + std::min(i, j)];
    if (is_set)
      lines.fail(
          "the entry is in the file twice, the other triangle counts too: expected each once");
    is_set = 1;
    A_(i, j) = A_(j, i) = value;
  }
  Matrix take() { return std::move(A_); }

 private:
  Matrix A_;
  std::vector<char> is_set_;
};

}  // namespace cbr
