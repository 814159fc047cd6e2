// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/nodes/dense_panels.hpp"

#include <algorithm>
#include <array>
#include <cassert>

#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/kernels/clones.hpp"
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

// y += sum of four columns x their weights. Of columns in cache it takes half the time of
// add_panel()
CBR_CLONES void add_four(const double* const* column, const double* weight, Index n,
                         double* __restrict__ y) {
  const double *a = column[0], *b = column[1], *c = column[2], *d = column[3];
  const double wa = weight[0], wb = weight[1], wc = weight[2], wd = weight[3];
  for (Index i = 0; i < n; ++i) y[i] += wa * a[i] + wb * b[i] + (wc * c[i] + wd * d[i]);
}

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

void add_weighted(const Matrix& S, const std::vector<RowWeight>& rows, Index begin, Index end,
                  double* y) {
  for (std::size_t i = 0; i < rows.size(); i += width) {
    const double* column[width];
    double weight[width] = {};
    for (std::size_t k = 0; k < width; ++k) {
      const RowWeight& of = rows[std::min(i + k, rows.size() - 1)];
      column[k] = S.col(of.row).data() + begin;
      if (i + k < rows.size()) weight[k] = of.weight;
    }
    add_four(column, weight, end - begin, y);
  }
}

Vector symmetric_product(const Matrix& S, const Vector& x) {
  thread_local Matrix given, answer;
  given = x;
  answer.setZero(x.size(), 1);
  add_symmetric_product(S, given, answer, n_threads());
  return answer.col(0);
}

}  // namespace cbr
