// SPDX-License-Identifier: GPL-3.0-or-later
// libFuzzer's entry of the target that CBR_FUZZ_TARGET names.
#include <cstddef>

#include "tests/fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  cbr::fuzz::CBR_FUZZ_TARGET({data, size});
  return 0;
}
