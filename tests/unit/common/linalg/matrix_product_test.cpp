// SPDX-License-Identifier: GPL-3.0-or-later
// A product that is compiled once has every byte of the one that Eigen instantiates for the
// operands' own types.
#include "common/linalg/matrix_product.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "common/base/types.hpp"

namespace cbr::test::matrix_product_test {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Map = Eigen::Map<const Matrix, 0, Eigen::OuterStride<>>;

static_assert(matrix_product::InMemory<Matrix> &&
              matrix_product::InMemory<Eigen::Transpose<const Matrix>>);
static_assert(matrix_product::InMemory<Eigen::Block<Matrix>>);
static_assert(!matrix_product::InMemory<Map> &&
              !matrix_product::InMemory<Eigen::Transpose<const Map>>);
static_assert(!matrix_product::InMemory<Vector> && !matrix_product::InMemory<Eigen::MatrixXf>);

// Maps are left to Eigen: they are the reference.
template <class T>
Map own(const T& A) {
  return {A.data(), A.rows(), A.cols(), Eigen::OuterStride<>(A.outerStride())};
}

void expect_same_bytes(const Matrix& a, const Matrix& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(0,
            std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())));
}

// C = A B, C + A B, C - A B, C + 0.3 A B into a matrix, a block and a matrix by rows. The products
// of a and b are compiled once, those of a_own and b_own, the same numbers as maps, are Eigen's.
template <class A, class B, class AOwn, class BOwn>
void compare(const A& a, const B& b, const AOwn& a_own, const BOwn& b_own) {
  const Index m = a.rows(), n = b.cols();
  const Matrix start = Matrix::Random(m + 3, n + 2);
  const auto each = [&](const auto& update) {
    Matrix once = start.topLeftCorner(m, n), reference = once;
    update(once, a, b);
    update(reference, a_own, b_own);
    expect_same_bytes(once, reference);
    Matrix into_block = start, reference_block = start;
    update(into_block.block(1, 1, m, n), a, b);
    update(reference_block.block(1, 1, m, n), a_own, b_own);
    expect_same_bytes(into_block, reference_block);
    RowMajor by_rows = start.topLeftCorner(m, n), reference_rows = by_rows;
    update(by_rows, a, b);
    update(reference_rows, a_own, b_own);
    expect_same_bytes(by_rows, reference_rows);
  };
  each([](auto&& C, const auto& x, const auto& y) { C.noalias() = x * y; });
  each([](auto&& C, const auto& x, const auto& y) { C.noalias() += x * y; });
  each([](auto&& C, const auto& x, const auto& y) { C.noalias() -= x * y; });
  each([](auto&& C, const auto& x, const auto& y) { C.noalias() += 0.3 * (x * y); });
}

// Eigen calls BLAS from a sum of 20 of the three sizes on: both sides of it, and thin matrices.
class MatrixProduct : public testing::TestWithParam<std::array<int, 3>> {};

TEST_P(MatrixProduct, HasEveryByteOfEigensOwn) {
  const auto [m, k, n] = GetParam();
  const Matrix A = Matrix::Random(m, k);
  const Matrix At = A.transpose();
  const Matrix B = Matrix::Random(k, n);
  const Matrix Bt = B.transpose();
  Matrix large = Matrix::Random(m + 4, k + 5);
  const auto block = large.block(1, 2, m, k);
  compare(A, B, own(A), own(B));
  compare(At.transpose(), B, own(At).transpose(), own(B));
  compare(A, Bt.transpose(), own(A), own(Bt).transpose());
  compare(At.transpose(), Bt.transpose(), own(At).transpose(), own(Bt).transpose());
  compare(block, B, own(block), own(B));
}

INSTANTIATE_TEST_SUITE_P(Sizes, MatrixProduct,
                         testing::Values(std::array{1, 1, 1}, std::array{2, 3, 4},
                                         std::array{3, 7, 5}, std::array{6, 6, 6},
                                         std::array{6, 7, 7}, std::array{1, 30, 1},
                                         std::array{1, 5, 30}, std::array{30, 1, 5},
                                         std::array{17, 2, 3}, std::array{40, 33, 21},
                                         std::array{100, 3, 64}));

TEST(MatrixProduct, OfNothingIsNothing) {
  const Matrix A(3, 0), B(0, 4);
  EXPECT_EQ(0, Matrix(A * B).norm());
  EXPECT_EQ(0, Matrix(Matrix(0, 3) * Matrix::Ones(3, 2)).size());
}

}  // namespace
}  // namespace cbr::test::matrix_product_test
