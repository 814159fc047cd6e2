// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/blas_threads.hpp"

#include <gtest/gtest.h>

namespace cbr::blas_kernels_test {
namespace {

TEST(BlasKernels, OnlyAFallbackIsBettered) {
  EXPECT_EQ(better_kernels("Prescott", true, true), "SkylakeX");
  EXPECT_EQ(better_kernels("Prescott", true, false), "Haswell");
  EXPECT_EQ(better_kernels("Prescott", false, false), "");  // a processor of 2004
  for (const char* known : {"Haswell", "Zen", "SkylakeX", "Sandybridge", "armv8", ""})
    EXPECT_EQ(better_kernels(known, true, true), "");
}

}  // namespace
}  // namespace cbr::blas_kernels_test
