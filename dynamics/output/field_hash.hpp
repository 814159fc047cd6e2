// SPDX-License-Identifier: GPL-3.0-or-later
// Hash of fields, to verify that those kept with a checkpoint are those written.
#pragma once

#include <string>

#include "common/base/types.hpp"
#include "common/linalg/row_matrix.hpp"

namespace cbr {

// A hash chain over datasets in the order of writing: name, shape and values of each.
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
