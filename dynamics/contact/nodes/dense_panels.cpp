// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/nodes/dense_panels.hpp"

#include <algorithm>
#include <array>
#include <cassert>

#include "common/base/row_threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/kernels/symmetric_product.hpp"

namespace cbr {
namespace {

constexpr int width = 4, lanes = 8;
using Lanes = double __attribute__((vector_size(8 * lanes)));
// Packed: Clang loses the alignment attribute of a vector type that is merely declared unaligned.
struct __attribute__((packed, aligned(8), may_alias)) StoredLanes {
  Lanes v;
};
const StoredLanes* at(const double* x) { return reinterpret_cast<const StoredLanes*>(x); }
StoredLanes* at(double* x) { return reinterpret_cast<StoredLanes*>(x); }

// Below this many bytes a thread costs more than it saves.
constexpr double threaded_bytes = 4e6;

template <int P>
using Columns = std::array<const double*, P>;

// y_k += columns x factor_k over the rows [begin, end)
template <int P, int K>
void add_panel(const Columns<P>& column, Index begin, Index end, const double (&factor)[K][P],
               const std::array<double*, K>& y) {
  Index i = begin;
  for (; i + lanes <= end; i += lanes) {
    Lanes sum[K];
    for (int k = 0; k < K; ++k) sum[k] = at(y[k] + i)->v;
    for (int c = 0; c < P; ++c) {
      const Lanes s = at(column[c] + i)->v;
      for (int k = 0; k < K; ++k) sum[k] += s * factor[k][c];
    }
    for (int k = 0; k < K; ++k) at(y[k] + i)->v = sum[k];
  }
  for (; i < end; ++i)
    for (int k = 0; k < K; ++k)
      for (int c = 0; c < P; ++c) y[k][i] += column[c][i] * factor[k][c];
}

// columns^T y over the rows [begin, end)
template <int P>
std::array<double, P> dot_panel(const Columns<P>& column, Index begin, Index end, const double* y) {
  Lanes sums[P] = {};
  Index i = begin;
  for (; i + lanes <= end; i += lanes)
    for (int c = 0; c < P; ++c) sums[c] += at(column[c] + i)->v * at(y + i)->v;
  std::array<double, P> dot{};
  for (int c = 0; c < P; ++c) {
    for (int lane = 0; lane < lanes; ++lane) dot[c] += sums[c][lane];
    for (Index row = i; row < end; ++row) dot[c] += column[c][row] * y[row];
  }
  return dot;
}

template <int P>
Columns<P> columns_from(const Matrix& L, Index first) {
  Columns<P> column;
  for (int c = 0; c < P; ++c) column[c] = L.col(first + c).data();
  return column;
}

template <int P>
void lower_panel(const Matrix& L, Index first, Index n, double* y) {
  const Columns<P> column = columns_from<P>(L, first);
  double factor[1][P];
  for (int c = 0; c < P; ++c) {
    for (int b = 0; b < c; ++b) y[first + c] += column[b][first + c] * factor[0][b];
    y[first + c] /= column[c][first + c];
    factor[0][c] = -y[first + c];
  }
  add_panel<P, 1>(column, first + P, n, factor, {y});
}

template <int P>
void transposed_panel(const Matrix& L, Index first, Index n, double* y) {
  const Columns<P> column = columns_from<P>(L, first);
  const std::array<double, P> dot = dot_panel<P>(column, first + P, n, y);
  for (int c = P - 1; c >= 0; --c) {
    double& of = y[first + c];
    of -= dot[c];
    for (int b = c + 1; b < P; ++b) of -= column[c][first + b] * y[first + b];
    of /= column[c][first + c];
  }
}

template <int P, int K>
void add_some(const Matrix& S, const Index* columns, const Matrix& X, Index begin, Index end,
              Matrix& Y) {
  Columns<P> column;
  double factor[K][P];
  std::array<double*, K> y;
  for (int k = 0; k < K; ++k) y[k] = Y.col(k).data();
  for (int c = 0; c < P; ++c) {
    column[c] = S.col(columns[c]).data();
    for (int k = 0; k < K; ++k) factor[k][c] = X(columns[c], k);
  }
  add_panel<P, K>(column, begin, end, factor, y);
}

template <int K>
void add_rows(const Matrix& S, const std::vector<Index>& columns, const Matrix& X, Index begin,
              Index end, Matrix& Y) {
  const Index n = static_cast<Index>(columns.size());
  Index j = 0;
  for (; j + width <= n; j += width) add_some<width, K>(S, columns.data() + j, X, begin, end, Y);
  for (; j < n; ++j) add_some<1, K>(S, columns.data() + j, X, begin, end, Y);
}

}  // namespace

void add_columns(const Matrix& S, const std::vector<Index>& columns, const Matrix& X, Matrix& Y,
                 int threads) {
  assert(X.cols() == 1 || X.cols() == 2);
  const auto rows = [&](Index begin, Index end) {
    X.cols() == 2 ? add_rows<2>(S, columns, X, begin, end, Y)
                  : add_rows<1>(S, columns, X, begin, end, Y);
  };
  const Index n = S.rows();
  if (threads <= 1 ||
      8.0 * static_cast<double>(n) * static_cast<double>(columns.size()) < threaded_bytes)
    return rows(0, n);
  run_kept_threads(threads, [&](int t) {
    // slices at multiples of `lanes`, so that sums do not depend on the number of threads
    const auto part = [&](int i) { return i == threads ? n : n * i / threads / lanes * lanes; };
    rows(part(t), part(t + 1));
  });
}

Vector symmetric_product(const Matrix& S, const Vector& x) {
  thread_local Matrix given, answer;
  given = x;
  answer.setZero(x.size(), 1);
  add_symmetric_product(S, given, answer, n_threads());
  return answer.col(0);
}

void solve_lower(const Matrix& L, Index n, double* y) {
  Index j = 0;
  for (; j + width <= n; j += width) lower_panel<width>(L, j, n, y);
  for (; j < n; ++j) lower_panel<1>(L, j, n, y);
}

void solve_lower_transposed(const Matrix& L, Index n, double* y) {
  Index j = n;
  while (j % width != 0) transposed_panel<1>(L, --j, n, y);
  for (; j > 0; j -= width) transposed_panel<width>(L, j - width, n, y);
}

}  // namespace cbr
