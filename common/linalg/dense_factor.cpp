// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/dense_factor.hpp"

#include <algorithm>

namespace cbr {

void mirror_lower(Matrix& A) {
  constexpr Index tile = 64;
  const Index n = A.rows();
  for (Index j0 = 0; j0 < n; j0 += tile) {
    for (Index i0 = j0; i0 < n; i0 += tile) {
      for (Index j = j0; j < std::min(j0 + tile, n); ++j)
        for (Index i = std::max(i0, j + 1); i < std::min(i0 + tile, n); ++i) A(j, i) = A(i, j);
    }
  }
}

}  // namespace cbr
