// SPDX-License-Identifier: GPL-3.0-or-later

#include <algorithm>

#include "common/linalg/kernels/narrow_product.hpp"
#include "common/linalg/sparse/supernodal.hpp"

namespace cbr::narrow {
namespace {

constexpr Index tile = SupernodeTree::tile;

const double* entry(const SupernodalFactor& factor, Index s, Index row, Index column) {
  return factor.x + factor.px[s] + column * factor.stride(s) + row;
}

}  // namespace

void solve_columns(const SupernodeTree& tree, Index s, Index begin, Index end, double* X_t,
                   double* work) {
  const SupernodalFactor& f = tree.factor();
  const Index first = f.first(s), stride = f.stride(s);
  double* X_b = X_t + width * (first + begin);
  for (Index j = begin; j < end; j += tile) {
    const Index size = std::min(tile, end - j);
    double* X_j = X_t + width * (first + j);
    if (j > begin) {
      multiply(entry(f, s, j, begin), stride, size, j - begin, X_b, work);
      for (Index i = 0; i < width * size; ++i) X_j[i] -= work[i];
    }
    multiply(tree.inverse(first + j), tile, size, size, X_j, work);
    std::copy_n(work, width * size, X_j);
  }
}

void solve_columns_transposed(const SupernodeTree& tree, Index s, Index begin, Index end,
                              double* X_t, double* work) {
  const SupernodalFactor& f = tree.factor();
  const Index first = f.first(s), stride = f.stride(s);
  for (Index j = begin + (end - begin - 1) / tile * tile; j >= begin; j -= tile) {
    const Index size = std::min(tile, end - j), after = end - j - size;
    double* X_j = X_t + width * (first + j);
    subtract_transposed(entry(f, s, j + size, j), stride, after, size, X_j + width * size, X_j);
    // X_j^T <- X_j^T L_jj^-1 = -(0 - X_j^T L_jj^-1)
    std::fill_n(work, width * size, 0.0);
    subtract_transposed(tree.inverse(first + j), tile, size, size, X_j, work);
    for (Index i = 0; i < width * size; ++i) X_j[i] = -work[i];
  }
}

void subtract_rows(const SupernodalFactor& factor, Index s, Index begin, Index end, Index first_row,
                   Index last_row, double* X_t, double* work) {
  const Index count = last_row - first_row;
  multiply(entry(factor, s, first_row, begin), factor.stride(s), count, end - begin,
           X_t + width * (factor.first(s) + begin), work);
  const Index* rows = factor.rows + factor.pi[s] + first_row;
  for (Index i = 0; i < count; ++i)
    for (Index c = 0; c < width; ++c) X_t[width * rows[i] + c] -= work[width * i + c];
}

void subtract_rows_transposed(const SupernodalFactor& factor, Index s, Index begin, Index end,
                              Index first_row, Index last_row, double* X_t, double* work) {
  const Index count = last_row - first_row;
  const Index* rows = factor.rows + factor.pi[s] + first_row;
  for (Index i = 0; i < count; ++i) std::copy_n(X_t + width * rows[i], width, work + width * i);
  subtract_transposed(entry(factor, s, first_row, begin), factor.stride(s), count, end - begin,
                      work, X_t + width * (factor.first(s) + begin));
}

}  // namespace cbr::narrow
