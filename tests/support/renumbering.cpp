// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/renumbering.hpp"

namespace cbr::test {

std::vector<Index> random_order(Index n, std::mt19937& random) {
  std::vector<Index> order = first_numbers(n);
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

std::vector<Index> inverse(const std::vector<Index>& order) {
  std::vector<Index> result(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) result[order[i]] = static_cast<Index>(i);
  return result;
}

}  // namespace cbr::test
