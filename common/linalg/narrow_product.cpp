// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/narrow_product.hpp"

#include <algorithm>
#include <cstring>

#include "common/linalg/clones.hpp"

namespace cbr::narrow {
namespace {

typedef double Lanes __attribute__((vector_size(width * sizeof(double))));

// Columns of L that are read side by side, their rows of X in registers: as many streams, which the
// processor reads ahead.
constexpr Index together = 8;

// Loops over columns are unrolled at every level of optimisation, as arrays of
// lanes stay in registers only then.
#define CBR_UNROLL _Pragma("GCC unroll 8")
#define CBR_INLINE inline __attribute__((always_inline))

// Y <- Y + L X of so many columns   (rows x width)
template <Index columns>
CBR_INLINE void add_columns(const double* L, Index stride, Index rows, const double* X_t,
                            double* Y_t) {
  Lanes x[columns];
  std::memcpy(x, X_t, sizeof x);
  for (Index i = 0; i < rows; ++i) {
    Lanes y;
    std::memcpy(&y, Y_t + width * i, sizeof y);
    Lanes z = {};
    __builtin_prefetch(L + (columns + i % columns) * stride + i / columns * columns);
    CBR_UNROLL
    for (Index r = 0; r < columns; r += 2) {
      y += L[r * stride + i] * x[r];
      if (r + 1 < columns) z += L[(r + 1) * stride + i] * x[r + 1];
    }
    y += z;
    std::memcpy(Y_t + width * i, &y, sizeof y);
  }
}

// X <- X - L^T Y of so many columns   (columns x width)
template <Index columns>
CBR_INLINE void subtract_columns(const double* L, Index stride, Index rows, const double* Y_t,
                                 double* X_t) {
  Lanes sum[columns];
  std::memcpy(sum, X_t, sizeof sum);
  for (Index i = 0; i < rows; ++i) {
    Lanes y;
    std::memcpy(&y, Y_t + width * i, sizeof y);
    __builtin_prefetch(L + (columns + i % columns) * stride + i / columns * columns);
    CBR_UNROLL
    for (Index r = 0; r < columns; ++r) sum[r] -= L[r * stride + i] * y;
  }
  std::memcpy(X_t, sum, sizeof sum);
}

CBR_CLONES void multiply_panel(const double* L, Index stride, Index rows, Index columns,
                               const double* X_t, double* Y_t) {
  std::fill_n(Y_t, width * rows, 0.0);
  Index j = 0;
  for (; j + together <= columns; j += together)
    add_columns<together>(L + j * stride, stride, rows, X_t + width * j, Y_t);
  const double *l = L + j * stride, *x = X_t + width * j;
  switch (columns - j) {
    case 7:
      return add_columns<7>(l, stride, rows, x, Y_t);
    case 6:
      return add_columns<6>(l, stride, rows, x, Y_t);
    case 5:
      return add_columns<5>(l, stride, rows, x, Y_t);
    case 4:
      return add_columns<4>(l, stride, rows, x, Y_t);
    case 3:
      return add_columns<3>(l, stride, rows, x, Y_t);
    case 2:
      return add_columns<2>(l, stride, rows, x, Y_t);
    case 1:
      return add_columns<1>(l, stride, rows, x, Y_t);
    default:
      return;
  }
}

CBR_CLONES void subtract_panel(const double* L, Index stride, Index rows, Index columns,
                               const double* Y_t, double* X_t) {
  Index j = 0;
  for (; j + together <= columns; j += together)
    subtract_columns<together>(L + j * stride, stride, rows, Y_t, X_t + width * j);
  const double* l = L + j * stride;
  double* x = X_t + width * j;
  switch (columns - j) {
    case 7:
      return subtract_columns<7>(l, stride, rows, Y_t, x);
    case 6:
      return subtract_columns<6>(l, stride, rows, Y_t, x);
    case 5:
      return subtract_columns<5>(l, stride, rows, Y_t, x);
    case 4:
      return subtract_columns<4>(l, stride, rows, Y_t, x);
    case 3:
      return subtract_columns<3>(l, stride, rows, Y_t, x);
    case 2:
      return subtract_columns<2>(l, stride, rows, Y_t, x);
    case 1:
      return subtract_columns<1>(l, stride, rows, Y_t, x);
    default:
      return;
  }
}

}  // namespace

void multiply(const double* L, Index stride, Index rows, Index columns, const double* X_t,
              double* Y_t) {
  multiply_panel(L, stride, rows, columns, X_t, Y_t);
}

void subtract_transposed(const double* L, Index stride, Index rows, Index columns,
                         const double* Y_t, double* X_t) {
  subtract_panel(L, stride, rows, columns, Y_t, X_t);
}

}  // namespace cbr::narrow
