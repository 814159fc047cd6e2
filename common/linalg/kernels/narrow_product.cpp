// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/kernels/narrow_product.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <utility>

#include "common/linalg/kernels/clones.hpp"

namespace cbr::narrow {
namespace {

// Prefetch distance in L (4 kB). Into the second cache, as requests for the first queue with all
// other reads.
constexpr Index ahead = 512;
constexpr int into_second_cache = 2, to_be_read = 0;

// A row of eight numbers, in registers of a processor's width.
template <int lanes>
struct Row {
  typedef double Lanes __attribute__((vector_size(lanes * sizeof(double))));
  static constexpr int parts = width / lanes;
  // Columns of L that are read side by side, their rows of X in registers: as many streams, which
  // the processor reads ahead.
  static constexpr Index together = parts == 1 ? 8 : 6;

  Lanes low, high;  // high: of two parts

  CBR_INLINE static Row read(const double* from) {
    Row row{};
    std::memcpy(&row.low, from, sizeof(Lanes));
    if constexpr (parts == 2) std::memcpy(&row.high, from + lanes, sizeof(Lanes));
    return row;
  }
  CBR_INLINE void write(double* to) const {
    std::memcpy(to, &low, sizeof(Lanes));
    if constexpr (parts == 2) std::memcpy(to + lanes, &high, sizeof(Lanes));
  }
  CBR_INLINE void add(double factor, const Row& x) {
    low += factor * x.low;
    if constexpr (parts == 2) high += factor * x.high;
  }
};
using Avx512 = Row<8>;  // 32 registers
using Avx2 = Row<4>;    // 16 registers, all of which X would need with eight columns

// Prefetches entries `skip` numbers behind row i of so many columns: one line at each call, all of
// them in `rows` calls.
template <Index columns>
CBR_INLINE void fetch(const double* L, Index stride, Index skip, Index i) {
  __builtin_prefetch(L + skip + i % columns * stride + i / columns * columns, to_be_read,
                     into_second_cache);
}

// From a group of columns to the one that is fetched beside it
template <typename In>
CBR_INLINE Index skip_of(Index stride, Index rows) {
  const Index group = std::max<Index>(1, rows * In::together);
  return (ahead + group - 1) / group * In::together * stride;
}

template <Index... r>
using Columns = std::integer_sequence<Index, r...>;

// Y <- Y + L X of the columns r   (rows x width)
template <typename In, Index... r>
CBR_INLINE void add_columns(const double* L, Index stride, Index rows, Index skip,
                            const double* X_t, double* Y_t, Columns<r...>) {
  const In x[] = {In::read(X_t + width * r)...};
  for (Index i = 0; i < rows; ++i) {
    In y = In::read(Y_t + width * i), z{};
    fetch<sizeof...(r)>(L, stride, skip, i);
    ((r % 2 ? z : y).add(L[r * stride + i], x[r]), ...);
    y.add(1, z);
    y.write(Y_t + width * i);
  }
}

// X <- X - L^T Y of the columns r   (columns x width)
template <typename In, Index... r>
CBR_INLINE void subtract_columns(const double* L, Index stride, Index rows, Index skip,
                                 const double* Y_t, double* X_t, Columns<r...>) {
  In sum[] = {In::read(X_t + width * r)...};
  for (Index i = 0; i < rows; ++i) {
    const In y = In::read(Y_t + width * i);
    fetch<sizeof...(r)>(L, stride, skip, i);
    (sum[r].add(-L[r * stride + i], y), ...);
  }
  (sum[r].write(X_t + width * r), ...);
}

// All columns: `most` side by side, then what is left.
template <typename In, bool transposed, Index most>
CBR_INLINE void panel(const double* L, Index stride, Index rows, Index columns, Index skip,
                      const double* from, double* to) {
  constexpr std::make_integer_sequence<Index, most> group;
  for (; columns >= most; columns -= most, L += most * stride) {
    if constexpr (transposed) {
      subtract_columns<In>(L, stride, rows, skip, from, to, group);
      to += width * most;
    } else {
      add_columns<In>(L, stride, rows, skip, from, to, group);
      from += width * most;
    }
  }
  if constexpr (most > 1) panel<In, transposed, most - 1>(L, stride, rows, columns, skip, from, to);
}

template <typename In, bool transposed>
CBR_INLINE void panel_in(const double* L, Index stride, Index rows, Index columns,
                         const double* from, double* to) {
  panel<In, transposed, In::together>(L, stride, rows, columns, skip_of<In>(stride, rows), from,
                                      to);
}

// Sums of two, so that an addition need not wait for the one before
template <typename In>
CBR_INLINE void sparse_columns(const Index* start, const Index* row, const double* value,
                               Index count, const double* X_t, double* Y_t) {
  for (Index j = 0; j < count; ++j) {
    In even{}, odd{};
    Index i = start[j];
    for (; i + 1 < start[j + 1]; i += 2) {
      even.add(value[i], In::read(X_t + width * row[i]));
      odd.add(value[i + 1], In::read(X_t + width * row[i + 1]));
    }
    if (i < start[j + 1]) even.add(value[i], In::read(X_t + width * row[i]));
    even.add(1, odd);
    even.write(Y_t + width * j);
  }
}

CBR_CLONES void add(const double* L, Index stride, Index rows, Index columns, const double* X_t,
                    double* Y_t) {
  panel_in<Avx2, false>(L, stride, rows, columns, X_t, Y_t);
}
CBR_CLONES void subtract(const double* L, Index stride, Index rows, Index columns,
                         const double* Y_t, double* X_t) {
  panel_in<Avx2, true>(L, stride, rows, columns, Y_t, X_t);
}

CBR_CLONES void sparse(const Index* start, const Index* row, const double* value, Index count,
                       const double* X_t, double* Y_t) {
  sparse_columns<Avx2>(start, row, value, count, X_t, Y_t);
}

#ifdef CBR_AVX512
CBR_AVX512 void add_wide(const double* L, Index stride, Index rows, Index columns,
                         const double* X_t, double* Y_t) {
  panel_in<Avx512, false>(L, stride, rows, columns, X_t, Y_t);
}
CBR_AVX512 void subtract_wide(const double* L, Index stride, Index rows, Index columns,
                              const double* Y_t, double* X_t) {
  panel_in<Avx512, true>(L, stride, rows, columns, Y_t, X_t);
}
#endif

}  // namespace

void multiply(const double* L, Index stride, Index rows, Index columns, const double* X_t,
              double* Y_t) {
  std::fill_n(Y_t, width * rows, 0.0);
#ifdef CBR_AVX512
  if (has_avx512()) return add_wide(L, stride, rows, columns, X_t, Y_t);
#endif
  add(L, stride, rows, columns, X_t, Y_t);
}

void subtract_transposed(const double* L, Index stride, Index rows, Index columns,
                         const double* Y_t, double* X_t) {
#ifdef CBR_AVX512
  if (has_avx512()) return subtract_wide(L, stride, rows, columns, Y_t, X_t);
#endif
  subtract(L, stride, rows, columns, Y_t, X_t);
}

void multiply_columns(const SparseMatrix& M, Index first, Index count, const double* X_t,
                      double* Y_t) {
  assert(M.isCompressed());
  sparse(M.outerIndexPtr() + first, M.innerIndexPtr(), M.valuePtr(), count, X_t, Y_t);
}

}  // namespace cbr::narrow
