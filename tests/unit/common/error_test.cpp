// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/error.hpp"

#include <gtest/gtest.h>

namespace cbr::error_test {

TEST(NearestName, findsTheSlipAndKeepsSilentOtherwise) {
  const std::vector<std::string> allowed = {"youngs_modulus", "poissons_ratio", "density"};
  EXPECT_EQ(nearest_name("young_modulus", allowed), ", did you mean 'youngs_modulus'?");
  EXPECT_EQ(nearest_name("Density", allowed), ", did you mean 'density'?");
  EXPECT_EQ(nearest_name("temperature", allowed), "");
}

}  // namespace cbr::error_test
