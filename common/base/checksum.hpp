// SPDX-License-Identifier: GPL-3.0-or-later
// XXH3 of 64 bits, piece by piece: detects numbers that were altered after writing. No
// defence against intent.
#pragma once

#include <cstddef>
#include <memory>

#include "common/base/types.hpp"

namespace cbr {

class Checksum {
 public:
  Checksum();
  ~Checksum();
  Checksum(const Checksum&) = delete;
  Checksum& operator=(const Checksum&) = delete;

  void add(const void* data, std::size_t bytes);
  Index value() const;  // its 64 bits as a signed number; of pieces the same as of them in one

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cbr
