// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/nodal/block_matrix.hpp"

#include <algorithm>

#include "dynamics/motion/nodal/mesh_kernels.hpp"

namespace cbr {

BlockMatrix block_matrix(const SparseMatrix& A) {
  const Index n = A.rows() / 3;
  BlockMatrix B;
  B.first.assign(n + 1, 0);
  // A is symmetric: columns 3 i .. 3 i + 2 hold the rows of block row i.
  std::vector<Index> mark(n, -1);
  std::vector<std::int32_t> of_row;
  for (Index i = 0; i < n; ++i) {
    of_row.clear();
    for (int c = 0; c < 3; ++c) {
      for (SparseMatrix::InnerIterator it(A, 3 * i + c); it; ++it) {
        const Index j = it.row() / 3;
        if (mark[j] == i) continue;
        mark[j] = i;
        of_row.push_back(static_cast<std::int32_t>(j));
      }
    }
    std::sort(of_row.begin(), of_row.end());
    B.column.insert(B.column.end(), of_row.begin(), of_row.end());
    B.first[i + 1] = static_cast<std::int64_t>(B.column.size());
  }
  B.values.assign(9 * B.column.size() + 1, 0);
  for (Index i = 0; i < n; ++i) {
    const auto begin = B.column.begin() + B.first[i], end = B.column.begin() + B.first[i + 1];
    for (int c = 0; c < 3; ++c) {
      for (SparseMatrix::InnerIterator it(A, 3 * i + c); it; ++it) {
        const auto b = std::lower_bound(begin, end, static_cast<std::int32_t>(it.row() / 3)) -
                       B.column.begin();
        B.values[9 * b + 3 * (it.row() % 3) + c] = it.value();
      }
    }
  }
  return B;
}

void multiply(const BlockMatrix& A, const double* x, double* y, RowThreads& threads) {
  threads.for_rows(
      A.rows(), [&](Index begin, Index end) { block_products(A, x, begin, end, y + 3 * begin); });
}

void add_rows(const BlockMatrix& A, const double* x, Index x_stride, Index begin, Index end,
              double* f, Index stride) {
  for (Index i = begin; i < end; ++i) {
    for (std::int64_t b = A.first[i]; b < A.first[i + 1]; ++b) {
      const double* v = A.values.data() + 9 * b;
      const double* u = x + A.column[b];
      for (int c = 0; c < 3; ++c)
        f[c * stride + i - begin] +=
            v[c] * u[0] + v[3 + c] * u[x_stride] + v[6 + c] * u[2 * x_stride];
    }
  }
}

SymmetricBlockMatrix symmetric_block_matrix(const SparseMatrix& A,
                                            const std::vector<Index>& order) {
  const Index n = A.rows() / 3;
  std::vector<Index> row_of(n), place(n, -1);
  for (Index i = 0; i < n; ++i) row_of[order[i]] = i;
  SymmetricBlockMatrix B;
  B.first.assign(n + 1, 0);
  const auto most = static_cast<std::size_t>((A.nonZeros() / 9 + n) / 2 + n);
  B.column.reserve(most);
  B.values.reserve(9 * most + 1);
  std::vector<std::int32_t> of_row;
  for (Index i = 0; i < n; ++i) {
    // A is symmetric: columns 3 i .. 3 i + 2 hold the rows of block row i. The diagonal block is
    // there though it were empty.
    of_row.assign(1, static_cast<std::int32_t>(i));
    const auto each = [&](const auto& use) {
      for (int r = 0; r < 3; ++r) {
        for (SparseMatrix::InnerIterator it(A, 3 * order[i] + r); it; ++it) {
          const Index j = row_of[it.row() / 3];
          if (j >= i) use(r, j, it);
        }
      }
    };
    each([&](int, Index j, const auto&) {
      if (j > i && place[j] != -2 - i) {
        place[j] = -2 - i;
        of_row.push_back(static_cast<std::int32_t>(j));
      }
    });
    std::sort(of_row.begin(), of_row.end());
    for (std::size_t k = 0; k < of_row.size(); ++k)
      place[of_row[k]] = B.first[i] + static_cast<Index>(k);
    B.column.insert(B.column.end(), of_row.begin(), of_row.end());
    B.first[i + 1] = static_cast<std::int64_t>(B.column.size());
    B.values.resize(9 * B.column.size(), 0);
    each([&](int r, Index j, const auto& it) {
      B.values[9 * place[j] + 3 * r + it.row() % 3] = it.value();
    });
    B.reach = std::max(B.reach, of_row.back() - i);
  }
  B.values.push_back(0);
  return B;
}

}  // namespace cbr
