// SPDX-License-Identifier: GPL-3.0-or-later
// Random orders of nodes and elements.
#pragma once

#include <random>
#include <vector>

#include "common/base/types.hpp"

namespace cbr::test {

// Old index of each new one: a permutation of 0 .. n - 1.
std::vector<Index> random_order(Index n, std::mt19937& random);
std::vector<Index> inverse(const std::vector<Index>& order);

}  // namespace cbr::test
