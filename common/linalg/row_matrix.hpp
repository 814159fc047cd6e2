// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/types.hpp"

namespace cbr {

// One contiguous row per coordinate, as in the files, for access to a few rows (V of a diagonal
// form).
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace cbr
