// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/kernels/symmetric_product.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "common/base/threads.hpp"
#include "common/linalg/kernels/clones.hpp"

namespace cbr {
namespace {

// Most rows of a block: four columns each of X and Y fit the second cache (256 kB) beside S. Longer
// pieces of a column touch fewer pages. Each part has two blocks or more, so that parts are of
// similar size.
constexpr Index most_block_rows = 4096;
// Blocks are dealt to this many partial sums, whatever the number of threads.
constexpr int n_parts = 4;
// From this many entries on (4 MB of the half, a quarter of a millisecond) threads that are kept
// gain more than they cost.
constexpr Index worth_a_thread = 1000000;

constexpr int strip = 4;

struct Strip {
  std::array<const double*, strip> s;  // columns of S
  const double* x;                     // rows of X; its columns are `stride` apart, as those of y
  double* y;
  Index stride, rows;
};

// y += S x_J and dot += S^T x over `columns` of the strip's columns J from `first` on, for m
// right-hand sides in one pass over S, so many numbers at a time.
template <int lanes, int first, int columns, int m>
CBR_INLINE void columns_product(const Strip& a, const double (&x_J)[strip][m],
                                double (&dot)[strip][m]) {
  typedef double Lanes __attribute__((vector_size(lanes * sizeof(double))));
  Lanes sums[columns][m] = {};
  Index i = 0;
  for (; i + lanes <= a.rows; i += lanes) {
    Lanes s[columns];
    CBR_UNROLL
    for (int j = 0; j < columns; ++j) std::memcpy(&s[j], a.s[first + j] + i, sizeof(Lanes));
    CBR_UNROLL
    for (int k = 0; k < m; ++k) {
      Lanes x, y;
      std::memcpy(&x, a.x + k * a.stride + i, sizeof(Lanes));
      std::memcpy(&y, a.y + k * a.stride + i, sizeof(Lanes));
      CBR_UNROLL
      for (int j = 0; j < columns; ++j) {
        y += s[j] * x_J[first + j][k];
        sums[j][k] += s[j] * x;
      }
      std::memcpy(a.y + k * a.stride + i, &y, sizeof(Lanes));
    }
  }
  for (int j = 0; j < columns; ++j) {
    for (int k = 0; k < m; ++k) {
      double sum = 0;
      for (int l = 0; l < lanes; ++l) sum += sums[j][k][l];
      dot[first + j][k] = sum;
    }
  }
  for (; i < a.rows; ++i) {
    for (int k = 0; k < m; ++k) {
      for (int j = first; j < first + columns; ++j) {
        a.y[k * a.stride + i] += a.s[j][i] * x_J[j][k];
        dot[j][k] += a.s[j][i] * a.x[k * a.stride + i];
      }
    }
  }
}

// Of the whole strip. `columns`: as many as keep the sums, S, x and y in registers.
template <int lanes, int columns, int m>
CBR_INLINE void strip_product(const Strip& a, const double (&x)[strip][m],
                              double (&dot)[strip][m]) {
  columns_product<lanes, 0, columns, m>(a, x, dot);
  if constexpr (columns < strip) columns_product<lanes, columns, strip - columns, m>(a, x, dot);
}

CBR_CLONES void product_1(const Strip& a, const double (&x)[strip][1], double (&dot)[strip][1]) {
  strip_product<4, 4>(a, x, dot);
}
CBR_CLONES void product_2(const Strip& a, const double (&x)[strip][2], double (&dot)[strip][2]) {
  strip_product<4, 4>(a, x, dot);
}
CBR_CLONES void product_3(const Strip& a, const double (&x)[strip][3], double (&dot)[strip][3]) {
  strip_product<4, 2>(a, x, dot);
}
CBR_CLONES void product_4(const Strip& a, const double (&x)[strip][4], double (&dot)[strip][4]) {
  strip_product<4, 2>(a, x, dot);
}
#ifdef CBR_AVX512
template <int m>
CBR_AVX512 void wide_product(const Strip& a, const double (&x)[strip][m], double (&dot)[strip][m]) {
  strip_product<8, 4>(a, x, dot);
}
#endif

template <int m>
void product(const Strip& a, const double (&x)[strip][m], double (&dot)[strip][m]) {
#ifdef CBR_AVX512
  if (has_avx512()) return wide_product(a, x, dot);
#endif
  if constexpr (m == 1) product_1(a, x, dot);
  if constexpr (m == 2) product_2(a, x, dot);
  if constexpr (m == 3) product_3(a, x, dot);
  if constexpr (m == 4) product_4(a, x, dot);
}

// The rows [first, last) of the lower triangle, and their mirror images above it.
template <int m>
void add_block(const Matrix& S, const double* X, Index first, Index last, double* Y) {
  const Index n = S.rows();
  for (Index j = 0; j < last; j += strip) {
    const Index columns = std::min<Index>(strip, last - j),
                below = std::max(first, std::min(j + strip, last));
    // The triangle on the diagonal
    for (Index c = j; c < j + columns; ++c) {
      for (Index i = std::max(first, c); i < below; ++i) {
        for (int k = 0; k < m; ++k) {
          Y[k * n + i] += S(i, c) * X[k * n + c];
          if (i != c) Y[k * n + c] += S(i, c) * X[k * n + i];
        }
      }
    }
    if (below >= last) continue;
    double x[strip][m] = {}, dot[strip][m] = {};
    Strip a{{}, X + below, Y + below, n, last - below};
    for (int c = 0; c < strip; ++c) {
      const Index column = std::min(j + c, j + columns - 1);
      a.s[c] = S.col(column).data() + below;
      for (int k = 0; k < m && c < columns; ++k) x[c][k] = X[k * n + column];
    }
    product(a, x, dot);
    for (Index c = 0; c < columns; ++c)
      for (int k = 0; k < m; ++k) Y[k * n + j + c] += dot[c][k];
  }
}

template <int m>
void add_product(const Matrix& S, const double* X, double* Y, int threads) {
  const Index n = S.rows();
  // whole strips
  const Index block_rows = std::clamp<Index>((n / (4 * n_parts) + 3) / 4 * 4, 64, most_block_rows);
  const Index n_blocks = (n + block_rows - 1) / block_rows;
  thread_local Matrix parts;  // kept from call to call; the workers have the caller's
  parts.setZero(n * m, n_parts);
  Matrix& sums = parts;
  const int used = n * n < worth_a_thread ? 1 : std::clamp(threads, 1, n_parts);
  run_kept_threads(used, [&](int t) {
    for (int part = t; part < n_parts; part += used) {
      for (Index b = 0; b < n_blocks; ++b) {
        // Rows further down are longer: dealt out there and back
        const Index turn = b % (2 * n_parts),
                    owner = turn < n_parts ? turn : 2 * n_parts - 1 - turn;
        if (owner == part)
          add_block<m>(S, X, b * block_rows, std::min(n, (b + 1) * block_rows),
                       sums.col(part).data());
      }
    }
  });
  Eigen::Map<Vector>(Y, n * m) += sums.rowwise().sum();
}

}  // namespace

void add_symmetric_product(const Matrix& S, const Matrix& X, Matrix& Y, int threads) {
  assert(S.rows() == S.cols() && X.rows() == S.rows() && Y.rows() == X.rows() &&
         Y.cols() == X.cols());
  for (Index first = 0; first < X.cols(); first += 4) {
    const double* x = X.col(first).data();
    double* y = Y.col(first).data();
    switch (std::min<Index>(4, X.cols() - first)) {
      case 1:
        add_product<1>(S, x, y, threads);
        break;
      case 2:
        add_product<2>(S, x, y, threads);
        break;
      case 3:
        add_product<3>(S, x, y, threads);
        break;
      default:
        add_product<4>(S, x, y, threads);
    }
  }
}

}  // namespace cbr
