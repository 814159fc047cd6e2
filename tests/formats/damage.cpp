// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/formats/damage.hpp"

namespace cbr::test {

bool is_integer(const RawDataset& values) {
  return std::holds_alternative<std::vector<Index>>(values) ||
         std::holds_alternative<IndexTable>(values);
}

RawDataset with_first(RawDataset values, double entry) {
  std::visit(
      [&](auto& array) {
        using Array = std::decay_t<decltype(array)>;
        if constexpr (std::is_same_v<Array, double>) {
          array = entry;
        } else {
          array.data()[0] = static_cast<typename std::decay_t<decltype(array.data()[0])>>(entry);
        }
      },
      values);
  return values;
}

// One row more and one row less.
std::vector<RawDataset> wrong_lengths(const RawDataset& values) {
  const auto resized = [&](Index change) {
    return std::visit(
        [&](auto array) -> RawDataset {
          using Array = std::decay_t<decltype(array)>;
          if constexpr (std::is_same_v<Array, double>) {
            return Vector(Vector::Constant(1 + change, array));
          } else if constexpr (std::is_same_v<Array, std::vector<Index>>) {
            array.resize(array.size() + static_cast<std::size_t>(change), array.back() + 1000);
            return array;
          } else {
            const Array whole = array;
            array.setZero(whole.rows() + change, whole.cols());
            const Index rows = std::min(whole.rows(), array.rows());
            array.topRows(rows) = whole.topRows(rows);
            return array;
          }
        },
        values);
  };
  return {resized(1), resized(-1)};
}

RawDataset of_other_rank(const RawDataset& values) {
  return std::visit(
      [&](const auto& array) -> RawDataset {
        using Array = std::decay_t<decltype(array)>;
        if constexpr (std::is_same_v<Array, double>) return Matrix(Matrix::Constant(1, 1, array));
        if constexpr (std::is_same_v<Array, Vector>) return Matrix(array);
        if constexpr (std::is_same_v<Array, Matrix>) return Vector(array.reshaped());
        if constexpr (std::is_same_v<Array, std::vector<Index>>)
          return IndexTable(IndexTable::Zero(static_cast<Index>(array.size()), 1));
        if constexpr (std::is_same_v<Array, IndexTable>)
          return std::vector<Index>(array.data(), array.data() + array.size());
      },
      values);
}

RawDataset of_other_type(const RawDataset& values) {
  return std::visit(
      [&](const auto& array) -> RawDataset {
        using Array = std::decay_t<decltype(array)>;
        if constexpr (std::is_same_v<Array, double>) return std::vector<Index>{1};
        if constexpr (std::is_same_v<Array, Vector>)
          return std::vector<Index>(static_cast<std::size_t>(array.size()), 1);
        if constexpr (std::is_same_v<Array, Matrix>)
          return IndexTable(array.template cast<Index>());
        if constexpr (std::is_same_v<Array, std::vector<Index>>)
          return Vector(Vector::Zero(static_cast<Index>(array.size())));
        if constexpr (std::is_same_v<Array, IndexTable>)
          return Matrix(array.template cast<double>());
      },
      values);
}

}  // namespace cbr::test
