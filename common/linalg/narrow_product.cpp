// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/narrow_product.hpp"

#include <algorithm>
#include <cstring>

#include "common/linalg/clones.hpp"

namespace cbr::narrow {
namespace {

typedef double Lanes __attribute__((vector_size(width * sizeof(double))));

// Rows, or columns, whose sums stay in registers; columns that are gone through before the next rows: their pages stay in the TLB.
constexpr Index together = 8, strip = 64;

}  // namespace

CBR_CLONES void multiply(const double* L, Index stride, Index rows, Index columns, const double* X_t, double* Y_t) {
  if (columns == 0) std::fill_n(Y_t, width * rows, 0.0);
  for (Index first = 0; first < columns; first += strip) {
    const Index last = std::min(first + strip, columns);
    Index i = 0;
    for (; i + together <= rows; i += together) {
      Lanes sum[together] = {};
      if (first > 0) std::memcpy(sum, Y_t + width * i, sizeof sum);
      for (Index j = first; j < last; ++j) {
        Lanes x;
        std::memcpy(&x, X_t + width * j, sizeof x);
        const double* l = L + j * stride + i;
        for (Index r = 0; r < together; ++r) sum[r] += l[r] * x;
      }
      std::memcpy(Y_t + width * i, sum, sizeof sum);
    }
    for (; i < rows; ++i) {
      for (Index c = 0; c < width; ++c) {
        double sum = first > 0 ? Y_t[width * i + c] : 0;
        for (Index j = first; j < last; ++j) sum += L[j * stride + i] * X_t[width * j + c];
        Y_t[width * i + c] = sum;
      }
    }
  }
}

CBR_CLONES void subtract_transposed(const double* L, Index stride, Index rows, Index columns, const double* Y_t, double* X_t) {
  Index j = 0;
  for (; j + together <= columns; j += together) {
    Lanes sum[together];
    std::memcpy(sum, X_t + width * j, sizeof sum);
    const double* l = L + j * stride;
    for (Index i = 0; i < rows; ++i) {
      Lanes y;
      std::memcpy(&y, Y_t + width * i, sizeof y);
      for (Index r = 0; r < together; ++r) sum[r] -= l[r * stride + i] * y;
    }
    std::memcpy(X_t + width * j, sum, sizeof sum);
  }
  for (; j < columns; ++j) {
    for (Index i = 0; i < rows; ++i)
      for (Index c = 0; c < width; ++c) X_t[width * j + c] -= L[j * stride + i] * Y_t[width * i + c];
  }
}

}  // namespace cbr::narrow
