// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of matrices by the node and dof that formats name them with.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/text_lines.hpp"
#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {

class RowPlaces {
 public:
  // modal_dof: what the format calls the dof of a modal coordinate.
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

}  // namespace cbr
