// SPDX-License-Identifier: GPL-3.0-or-later
// Products of two matrices of run-time size, compiled once. Eigen would instantiate each of them
// for each pair of operand types: by coefficients, by columns, by rows and through BLAS. That took
// a third of the compiler's time (docs/decisions/build-time.md). multiply() lets Eigen choose among
// these ways as before, so every digit stays. A specialisation of generic_product_impl is Eigen's
// own way for products of a user (its page "Matrix-free solvers"). The header is precompiled
// (cmake/precompiled): no source includes it by itself, and without it all works alike.
#pragma once

#include <Eigen/Core>

#include <type_traits>

namespace cbr::matrix_product {

// A matrix in memory: its columns, or its rows when transposed, stand `stride` entries apart.
struct Operand {
  const double* data;
  Eigen::Index rows, cols, stride;
  bool transposed;
};
struct Target {
  double* data;
  Eigen::Index rows, cols, stride;
};
enum class Into { assign, add, subtract };

// C <- A B, C + A B, C - A B; no operand overlaps C.
void multiply(const Target& C, const Operand& A, const Operand& B, Into into);
// C <- C + alpha A B
void scale_and_add(const Target& C, const Operand& A, const Operand& B, double alpha);

template <class T>
struct is_map : std::false_type {};
template <class P, int O, class S>
struct is_map<Eigen::Map<P, O, S>> : std::true_type {};
template <class T>
struct is_map<Eigen::Transpose<T>> : is_map<std::remove_const_t<T>> {};

template <class T>
constexpr bool has_run_time_size = (T::RowsAtCompileTime == Eigen::Dynamic) &&
                                   (T::ColsAtCompileTime == Eigen::Dynamic) &&
                                   (T::MaxRowsAtCompileTime == Eigen::Dynamic) &&
                                   (T::MaxColsAtCompileTime == Eigen::Dynamic);

// A matrix of run-time size that stands in memory, or its transpose. A map is none of these: its
// products stay Eigen's, and multiply() makes use of that.
template <class T>
concept InMemory = has_run_time_size<T> && !is_map<T>::value &&
                   bool(Eigen::internal::blas_traits<T>::HasUsableDirectAccess) &&
                   !bool(Eigen::internal::blas_traits<T>::HasScalarFactor) &&
                   std::is_same_v<typename T::Scalar, double>;

template <class T>
Operand operand(const T& matrix) {
  const auto& plain = Eigen::internal::blas_traits<T>::extract(matrix);
  return {plain.data(), matrix.rows(), matrix.cols(), plain.outerStride(),
          bool(T::Flags & Eigen::RowMajorBit)};
}

// Column-major with contiguous columns, as Target requires.
template <class T>
constexpr bool is_column_major_target =
    (T::RowsAtCompileTime == Eigen::Dynamic) && (T::ColsAtCompileTime == Eigen::Dynamic) &&
    (T::InnerStrideAtCompileTime == 1) && !bool(T::Flags & Eigen::RowMajorBit) &&
    bool(T::Flags & Eigen::DirectAccessBit) && std::is_same_v<typename T::Scalar, double>;

using ColumnMap = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using RowMap = Eigen::Transpose<const ColumnMap>;

// Calls f with the operand as one of two types.
template <class F>
void with_map(const Operand& A, F&& f) {
  if (A.transposed) {
    const ColumnMap map(A.data, A.cols, A.rows, Eigen::OuterStride<>(A.stride));
    f(map.transpose());
  } else {
    f(ColumnMap(A.data, A.rows, A.cols, Eigen::OuterStride<>(A.stride)));
  }
}

}  // namespace cbr::matrix_product

namespace Eigen::internal {

template <class Lhs, class Rhs>
requires(cbr::matrix_product::InMemory<Lhs>&& cbr::matrix_product::InMemory<
         Rhs>) struct generic_product_impl<Lhs, Rhs, DenseShape, DenseShape, GemmProduct>
    : generic_product_impl_base<
          Lhs, Rhs, generic_product_impl<Lhs, Rhs, DenseShape, DenseShape, GemmProduct>> {
  template <class Dst>
  static cbr::matrix_product::Target target(Dst& dst) {
    return {dst.data(), dst.rows(), dst.cols(), dst.outerStride()};
  }
  // Other targets, by rows or of fixed size, are few: Eigen's own way.
  template <class Dst, class F>
  static void elsewhere(const Lhs& lhs, const Rhs& rhs, F&& f) {
    cbr::matrix_product::with_map(cbr::matrix_product::operand(lhs), [&](const auto& a) {
      cbr::matrix_product::with_map(cbr::matrix_product::operand(rhs), [&](const auto& b) {
        using A = std::remove_cvref_t<decltype(a)>;
        using B = std::remove_cvref_t<decltype(b)>;
        f(generic_product_impl<A, B, DenseShape, DenseShape, GemmProduct>(), a, b);
      });
    });
  }

  template <class Dst>
  static void evalTo(Dst& dst, const Lhs& lhs, const Rhs& rhs) {
    using namespace cbr::matrix_product;
    if constexpr (is_column_major_target<Dst>)
      multiply(target(dst), operand(lhs), operand(rhs), Into::assign);
    else
      elsewhere<Dst>(lhs, rhs, [&](auto product, const auto& a, const auto& b) {
        decltype(product)::evalTo(dst, a, b);
      });
  }
  template <class Dst>
  static void addTo(Dst& dst, const Lhs& lhs, const Rhs& rhs) {
    using namespace cbr::matrix_product;
    if constexpr (is_column_major_target<Dst>)
      multiply(target(dst), operand(lhs), operand(rhs), Into::add);
    else
      elsewhere<Dst>(lhs, rhs, [&](auto product, const auto& a, const auto& b) {
        decltype(product)::addTo(dst, a, b);
      });
  }
  template <class Dst>
  static void subTo(Dst& dst, const Lhs& lhs, const Rhs& rhs) {
    using namespace cbr::matrix_product;
    if constexpr (is_column_major_target<Dst>)
      multiply(target(dst), operand(lhs), operand(rhs), Into::subtract);
    else
      elsewhere<Dst>(lhs, rhs, [&](auto product, const auto& a, const auto& b) {
        decltype(product)::subTo(dst, a, b);
      });
  }
  template <class Dst>
  static void scaleAndAddTo(Dst& dst, const Lhs& lhs, const Rhs& rhs, const double& alpha) {
    using namespace cbr::matrix_product;
    if constexpr (is_column_major_target<Dst>)
      scale_and_add(target(dst), operand(lhs), operand(rhs), alpha);
    else
      elsewhere<Dst>(lhs, rhs, [&](auto product, const auto& a, const auto& b) {
        decltype(product)::scaleAndAddTo(dst, a, b, alpha);
      });
  }
};

}  // namespace Eigen::internal
