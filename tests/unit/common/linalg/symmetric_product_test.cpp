// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/kernels/symmetric_product.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace cbr::symmetric_product_test {
namespace {

TEST(SymmetricProduct, AnswersAsTheWholeMatrixDoesAndReadsTheLowerTriangle) {
  std::srand(3);
  for (const Index n : {0, 1, 3, 4, 7, 8, 13, 511, 512, 515, 1100}) {
    const Matrix A = Matrix::Random(n, n), S = A + A.transpose();
    Matrix lower = S;
    lower.triangularView<Eigen::StrictlyUpper>().setConstant(
        std::numeric_limits<double>::quiet_NaN());
    for (const Index m : {0, 1, 2, 3, 4, 6}) {
      const Matrix X = Matrix::Random(n, m), Y0 = Matrix::Random(n, m), expected = Y0 + S * X;
      Matrix Y = Y0;
      add_symmetric_product(lower, X, Y);
      EXPECT_LE((Y - expected).cwiseAbs().sum(),
                1e-14 * static_cast<double>(n) * (1 + expected.cwiseAbs().sum()))
          << n << " x " << m;
      Matrix threads = Y0;
      add_symmetric_product(lower, X, threads, 2);
      EXPECT_EQ(Y, threads);
    }
  }
}

}  // namespace
}  // namespace cbr::symmetric_product_test
