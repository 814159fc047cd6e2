// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/field_hash.hpp"

#include "common/scene/scene.hpp"

namespace cbr {

template <typename Array>
void FieldHash::add_bytes(const std::string& dataset, const Array& values) {
  const auto n = static_cast<std::size_t>(values.size()) * sizeof *values.data();
  text_ = bytes_hash(text_ + dataset + ' ' + std::to_string(values.rows()) + ' ' +
                     std::to_string(values.cols()) + ' ' +
                     bytes_hash({reinterpret_cast<const char*>(values.data()), n}));
}

void FieldHash::add(const std::string& dataset, const RowMatrix& values) {
  add_bytes(dataset, values);
}
void FieldHash::add_indices(const std::string& dataset, const IndexTable& values) {
  add_bytes(dataset, values);
}

}  // namespace cbr
