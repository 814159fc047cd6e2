// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/narrow_product.hpp"

#include <algorithm>
#include <cstring>

#include "common/linalg/clones.hpp"

namespace cbr::narrow {
namespace {

typedef double Lanes __attribute__((vector_size(width * sizeof(double))));

// Columns of L that are read side by side, their rows of X in registers.
constexpr Index together = 8;

}  // namespace

CBR_CLONES void multiply(const double* L, Index stride, Index rows, Index columns, const double* X_t, double* Y_t) {
  std::fill_n(Y_t, width * rows, 0.0);
  Index j = 0;
  // Some columns go down the rows side by side: as many streams, which the processor reads ahead
  for (; j + together <= columns; j += together) {
    Lanes x[together];
    std::memcpy(x, X_t + width * j, sizeof x);
    const double* l = L + j * stride;
    for (Index i = 0; i < rows; ++i) {
      Lanes y, z = {};
      std::memcpy(&y, Y_t + width * i, sizeof y);
      for (Index r = 0; r < together; r += 2) {
        y += l[r * stride + i] * x[r];
        z += l[(r + 1) * stride + i] * x[r + 1];
      }
      y += z;
      std::memcpy(Y_t + width * i, &y, sizeof y);
    }
  }
  for (; j < columns; ++j) {
    Lanes x;
    std::memcpy(&x, X_t + width * j, sizeof x);
    for (Index i = 0; i < rows; ++i) {
      Lanes y;
      std::memcpy(&y, Y_t + width * i, sizeof y);
      y += L[j * stride + i] * x;
      std::memcpy(Y_t + width * i, &y, sizeof y);
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
