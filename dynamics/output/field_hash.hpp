// SPDX-License-Identifier: GPL-3.0-or-later
// Tells whether the fields that a checkpoint has kept are those that were written.
#pragma once

#include <string>

#include "common/base/types.hpp"
#include "common/linalg/row_matrix.hpp"

namespace cbr {

// A chain over datasets in the order in which they are written: each one's name, shape and values.
class FieldHash {
 public:
  void add(const std::string& dataset, const RowMatrix& values);
  void add_indices(const std::string& dataset, const IndexTable& values);
  const std::string& text() const { return text_; }

 private:
  template <typename Array>
  void add_bytes(const std::string& dataset, const Array& values);
  std::string text_;
};

}  // namespace cbr
