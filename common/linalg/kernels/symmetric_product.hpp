// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/types.hpp"

namespace cbr {

// Y += S X of a symmetric S (n x n, only the lower triangle is read), X and Y n x m with few
// columns. Reading S dominates the cost: 4 n^2 bytes for up to four columns, by up to `threads`
// threads. The sums do not depend on the number of threads.
void add_symmetric_product(const Matrix& S, const Matrix& X, Matrix& Y, int threads = 1);

}  // namespace cbr
