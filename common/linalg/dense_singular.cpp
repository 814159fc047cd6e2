// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/SVD>

#include "common/linalg/dense.hpp"

namespace cbr {

// By rotations. BDCSVD, faster for many columns, does the same below 16, and the callers have six.
// It would cost the compiler three times as much.
RightSingular right_singular(const Matrix& A) {
  const Eigen::JacobiSVD<Matrix> svd(A, Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixV()};
}

}  // namespace cbr
