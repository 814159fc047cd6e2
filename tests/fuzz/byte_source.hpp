// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstring>

#include "tests/fuzz/targets.hpp"

namespace cbr::fuzz {

// Reads bytes in sequence as numbers; zeros after the end.
class ByteSource {
 public:
  explicit ByteSource(Bytes bytes) : rest_(bytes) {}
  bool empty() const { return rest_.empty(); }

  template <class T>
  T take() {
    T value{};
    const std::size_t n = rest_.size() < sizeof(T) ? rest_.size() : sizeof(T);
    if (n > 0) std::memcpy(&value, rest_.data(), n);
    rest_ = rest_.subspan(n);
    return value;
  }
  std::size_t below(std::size_t n) { return n == 0 ? 0 : take<std::uint8_t>() % n; }

 private:
  Bytes rest_;
};

}  // namespace cbr::fuzz
