// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/lower_updates.hpp"

#include <cblas.h>
#include <lapacke.h>

#include <algorithm>
#include <atomic>

#include "common/base/threads.hpp"
#include "common/base/types.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// work(row, rows, column, columns) for the tiles of the lower triangle of m rows.
template <typename Work>
void for_tiles(Index m, const Work& work) {
  const Index n = update_tiles(m);
  share_tasks(n * n, true, [&](Index i) {
    const Index column = i / n * update_tile, row = i % n * update_tile;
    if (row >= column)
      work(row, std::min(update_tile, m - row), column, std::min(update_tile, m - column));
  });
}

// C <- C - A B^T   (m x n, k columns of A and B)
void subtract_product(Index m, Index n, Index k, const double* A, Index A_stride, const double* B,
                      Index B_stride, double* C, Index C_stride) {
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, as_int(m), as_int(n), as_int(k), -1.0, A,
              as_int(A_stride), B, as_int(B_stride), 1.0, C, as_int(C_stride));
}

}  // namespace

void subtract_square(const Eigen::Ref<const Matrix>& L, bool share, Eigen::Ref<Matrix> A) {
  const Index stride = L.outerStride(), k = L.cols();
  const auto on_diagonal = [&](Index row, Index rows) {
    cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, as_int(rows), as_int(k), -1.0,
                L.data() + row, as_int(stride), 1.0, A.data() + row * (A.outerStride() + 1),
                as_int(A.outerStride()));
  };
  if (!share) return on_diagonal(0, A.rows());
  for_tiles(A.rows(), [&](Index row, Index rows, Index column, Index columns) {
    if (row == column) return on_diagonal(row, rows);
    subtract_product(rows, columns, k, L.data() + row, stride, L.data() + column, stride,
                     &A(row, column), A.outerStride());
  });
}

void subtract_pair(const Eigen::Ref<const Matrix>& W, const Eigen::Ref<const Matrix>& Y, bool share,
                   Eigen::Ref<Matrix> A) {
  const Index w = W.outerStride(), y = Y.outerStride(), k = W.cols();
  const auto on_diagonal = [&](Index row, Index rows) {
    cblas_dsyr2k(CblasColMajor, CblasLower, CblasNoTrans, as_int(rows), as_int(k), -1.0,
                 W.data() + row, as_int(w), Y.data() + row, as_int(y), 1.0,
                 A.data() + row * (A.outerStride() + 1), as_int(A.outerStride()));
  };
  if (!share) return on_diagonal(0, A.rows());
  for_tiles(A.rows(), [&](Index row, Index rows, Index column, Index columns) {
    if (row == column) return on_diagonal(row, rows);
    subtract_product(rows, columns, k, W.data() + row, w, Y.data() + column, y, &A(row, column),
                     A.outerStride());
    subtract_product(rows, columns, k, Y.data() + row, y, W.data() + column, w, &A(row, column),
                     A.outerStride());
  });
}

bool factor_columns(Eigen::Ref<Matrix> F) {
  // Columns that are factored before those after them
  constexpr Index block = 128;
  const Index height = F.rows(), columns = F.cols(), stride = F.outerStride();
  for (Index j = 0; j < columns; j += block) {
    const Index size = std::min(block, columns - j), after = j + size;
    if (LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', as_int(size), &F(j, j), as_int(stride)) != 0)
      return false;
    share_tasks(update_tiles(height - after), true, [&](Index i) {
      const Index row = after + i * update_tile;
      cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit,
                  as_int(std::min(update_tile, height - row)), as_int(size), 1.0, &F(j, j),
                  as_int(stride), &F(row, j), as_int(stride));
    });
    const Index wide = update_tiles(columns - after), high = update_tiles(height - after);
    share_tasks(wide * high, true, [&](Index i) {
      const Index column = after + i / high * update_tile,
                  n = std::min(update_tile, columns - column);
      Index row = after + i % high * update_tile, m = std::min(update_tile, height - row);
      if (row < column) return;
      if (row == column) {
        cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, as_int(n), as_int(size), -1.0,
                    &F(row, j), as_int(stride), 1.0, &F(row, column), as_int(stride));
        row += n;
        m -= n;
      }
      if (m > 0)
        subtract_product(m, n, size, &F(row, j), stride, &F(column, j), stride, &F(row, column),
                         stride);
    });
  }
  return true;
}

// As LAPACK's dsygst: each block of columns updates the rows and columns after it, and is then
// divided by the rest of L.
void divide_both_sides(const Matrix& L, Eigen::Ref<Matrix> A) {
  constexpr Index block = 256, strip = 64;
  const Index n = A.rows(), a = A.outerStride(), l = L.outerStride();
  for (Index j = 0; j < n; j += block) {
    const Index size = std::min(block, n - j), after = j + size, left = n - after;
    LAPACKE_dsygst_work(LAPACK_COL_MAJOR, 1, 'L', as_int(size), &A(j, j), as_int(a), &L(j, j),
                        as_int(l));
    // A_21 - L_21 A_11 / 2
    const auto take_half = [&](Index row, Index rows) {
      cblas_dsymm(CblasColMajor, CblasRight, CblasLower, as_int(rows), as_int(size), -0.5, &A(j, j),
                  as_int(a), &L(row, j), as_int(l), 1.0, &A(row, j), as_int(a));
    };
    const auto for_rows = [&](const auto& work) {
      share_tasks(update_tiles(left), true, [&](Index i) {
        const Index row = after + i * update_tile;
        work(row, std::min(update_tile, n - row));
      });
    };
    for_rows([&](Index row, Index rows) {
      cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, as_int(rows),
                  as_int(size), 1.0, &L(j, j), as_int(l), &A(row, j), as_int(a));
      take_half(row, rows);
    });
    subtract_pair(A.block(after, j, left, size), L.block(after, j, left, size), true,
                  A.bottomRightCorner(left, left));
    for_rows(take_half);
    if (left == 0) break;
    share_tasks((size + strip - 1) / strip, true, [&](Index i) {
      const Index column = j + i * strip;
      cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, as_int(left),
                  as_int(std::min(strip, after - column)), 1.0, &L(after, after), as_int(l),
                  &A(after, column), as_int(a));
    });
  }
}

void share_tasks(Index n, bool share, const std::function<void(Index)>& task) {
  const int threads = share ? static_cast<int>(std::min<Index>(n_threads(), n)) : 1;
  std::atomic<Index> next{0};
  run_kept_threads(threads, [&](int) {
    for (Index i = next++; i < n; i = next++) task(i);
  });
}

void mirror_lower(Matrix& A) {
  constexpr Index tile = 64;
  const Index n = A.rows();
  for (Index j0 = 0; j0 < n; j0 += tile) {
    for (Index i0 = j0; i0 < n; i0 += tile) {
      for (Index j = j0; j < std::min(j0 + tile, n); ++j)
        for (Index i = std::max(i0, j + 1); i < std::min(i0 + tile, n); ++i) A(j, i) = A(i, j);
    }
  }
}

}  // namespace cbr
