// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/kernels/narrow_product.hpp"

#include <algorithm>
#include <cstring>

#include "common/linalg/kernels/clones.hpp"

namespace cbr::narrow {
namespace {

typedef double Lanes __attribute__((vector_size(width * sizeof(double))));

// Columns of L that are read side by side, their rows of X in registers: as many streams, which the
// processor reads ahead.
constexpr Index together = 8;

// Prefetch distance in L (4 kB). Into the second cache, as requests for the first queue with all
// other reads.
constexpr Index ahead = 512;
constexpr int into_second_cache = 2, to_be_read = 0;

// Loops over columns are unrolled at every level of optimisation, as arrays of
// lanes stay in registers only then.
#define CBR_UNROLL _Pragma("GCC unroll 8")
#define CBR_INLINE inline __attribute__((always_inline))

// Prefetches entries `skip` numbers behind row i of so many columns: one line at each call, all of
// them in `rows` calls.
template <Index columns>
CBR_INLINE void fetch(const double* L, Index stride, Index skip, Index i) {
  __builtin_prefetch(L + skip + i % columns * stride + i / columns * columns, to_be_read,
                     into_second_cache);
}

// From a group of columns to the one that is fetched beside it
Index skip_of(Index stride, Index rows) {
  const Index group = std::max<Index>(1, rows * together);
  return (ahead + group - 1) / group * together * stride;
}

// Y <- Y + L X of so many columns   (rows x width)
template <Index columns>
CBR_INLINE void add_columns(const double* L, Index stride, Index rows, Index skip,
                            const double* X_t, double* Y_t) {
  Lanes x[columns];
  std::memcpy(x, X_t, sizeof x);
  for (Index i = 0; i < rows; ++i) {
    Lanes y;
    std::memcpy(&y, Y_t + width * i, sizeof y);
    Lanes z = {};
    fetch<columns>(L, stride, skip, i);
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
CBR_INLINE void subtract_columns(const double* L, Index stride, Index rows, Index skip,
                                 const double* Y_t, double* X_t) {
  Lanes sum[columns];
  std::memcpy(sum, X_t, sizeof sum);
  for (Index i = 0; i < rows; ++i) {
    Lanes y;
    std::memcpy(&y, Y_t + width * i, sizeof y);
    fetch<columns>(L, stride, skip, i);
    CBR_UNROLL
    for (Index r = 0; r < columns; ++r) sum[r] -= L[r * stride + i] * y;
  }
  std::memcpy(X_t, sum, sizeof sum);
}

CBR_CLONES void multiply_panel(const double* L, Index stride, Index rows, Index columns,
                               const double* X_t, double* Y_t) {
  std::fill_n(Y_t, width * rows, 0.0);
  const Index skip = skip_of(stride, rows);
  Index j = 0;
  for (; j + together <= columns; j += together)
    add_columns<together>(L + j * stride, stride, rows, skip, X_t + width * j, Y_t);
  const double *l = L + j * stride, *x = X_t + width * j;
  switch (columns - j) {
    case 7:
      return add_columns<7>(l, stride, rows, skip, x, Y_t);
    case 6:
      return add_columns<6>(l, stride, rows, skip, x, Y_t);
    case 5:
      return add_columns<5>(l, stride, rows, skip, x, Y_t);
    case 4:
      return add_columns<4>(l, stride, rows, skip, x, Y_t);
    case 3:
      return add_columns<3>(l, stride, rows, skip, x, Y_t);
    case 2:
      return add_columns<2>(l, stride, rows, skip, x, Y_t);
    case 1:
      return add_columns<1>(l, stride, rows, skip, x, Y_t);
    default:
      return;
  }
}

CBR_CLONES void subtract_panel(const double* L, Index stride, Index rows, Index columns,
                               const double* Y_t, double* X_t) {
  const Index skip = skip_of(stride, rows);
  Index j = 0;
  for (; j + together <= columns; j += together)
    subtract_columns<together>(L + j * stride, stride, rows, skip, Y_t, X_t + width * j);
  const double* l = L + j * stride;
  double* x = X_t + width * j;
  switch (columns - j) {
    case 7:
      return subtract_columns<7>(l, stride, rows, skip, Y_t, x);
    case 6:
      return subtract_columns<6>(l, stride, rows, skip, Y_t, x);
    case 5:
      return subtract_columns<5>(l, stride, rows, skip, Y_t, x);
    case 4:
      return subtract_columns<4>(l, stride, rows, skip, Y_t, x);
    case 3:
      return subtract_columns<3>(l, stride, rows, skip, Y_t, x);
    case 2:
      return subtract_columns<2>(l, stride, rows, skip, Y_t, x);
    case 1:
      return subtract_columns<1>(l, stride, rows, skip, Y_t, x);
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
