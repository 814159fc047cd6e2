// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/matrix_product.hpp"

#include "common/linalg/blas_threads.hpp"

namespace cbr::matrix_product {
namespace {

using TargetMap = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

double flops(const Target& C, const Operand& A) {
  return 2.0 * static_cast<double>(C.rows) * static_cast<double>(C.cols) *
         static_cast<double>(A.cols);
}

TargetMap map(const Target& C) { return {C.data, C.rows, C.cols, Eigen::OuterStride<>(C.stride)}; }

}  // namespace

void multiply(const Target& C, const Operand& A, const Operand& B, Into into) {
  const LargeBlasWork blas(flops(C, A));
  TargetMap target = map(C);
  with_map(A, [&](const auto& a) {
    with_map(B, [&](const auto& b) {
      if (into == Into::assign)
        target.noalias() = a * b;
      else if (into == Into::add)
        target.noalias() += a * b;
      else
        target.noalias() -= a * b;
    });
  });
}

void scale_and_add(const Target& C, const Operand& A, const Operand& B, double alpha) {
  const LargeBlasWork blas(flops(C, A));
  TargetMap target = map(C);
  with_map(A, [&](const auto& a) {
    with_map(B, [&](const auto& b) {
      using Implementation =
          Eigen::internal::generic_product_impl<std::remove_cvref_t<decltype(a)>,
                                                std::remove_cvref_t<decltype(b)>, Eigen::DenseShape,
                                                Eigen::DenseShape, Eigen::GemmProduct>;
      Implementation::scaleAndAddTo(target, a, b, alpha);
    });
  });
}

}  // namespace cbr::matrix_product
