// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/supernodal_cholesky.hpp"

#include <cblas.h>
#include <lapacke.h>

#include <algorithm>

namespace cbr {
namespace {

int as_int(Index n) { return static_cast<int>(n); }

// Columns that are factored before those after them, and sides of what one thread takes at a time.
constexpr Index block = 128, tile = 256;

class Factoriser final : public Fronts {
 public:
  Factoriser(const SupernodeTree& tree, const ShiftedMatrix& A, double* x, const Progress& progress)
      : Fronts(tree, A, progress), x_(x) {}

  Factored factor_all() {
    switch (run()) {
      case Outcome::done:
        return Factored::done;
      case Outcome::stopped:
        return Factored::not_definite;
      case Outcome::foreign:
        return Factored::foreign;
    }
    return Factored::foreign;
  }

 private:
  bool eliminate(const Front& front, Matrix& F, Matrix& rest, bool alone) override {
    if (!(alone ? shared_columns(F) : own_columns(F))) return false;
    if (front.below() > 0) subtract_square(F.bottomRows(front.below()), alone, rest);
    store(front, F, alone);
    return true;
  }

  // F_1 = L_1 L_1^T, L_2 = F_2 L_1^-T
  static bool own_columns(Matrix& F) {
    const Index height = F.rows(), columns = F.cols();
    if (LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', as_int(columns), F.data(), as_int(height)) != 0) return false;
    divide(F, 0, columns, columns, height - columns);
    return true;
  }

  // The same, block of columns by block: the rows below one are divided, and the columns after it updated, on all threads.
  static bool shared_columns(Matrix& F) {
    const Index height = F.rows(), columns = F.cols();
    const int stride = as_int(height);
    for (Index j = 0; j < columns; j += block) {
      const Index size = std::min(block, columns - j), after = j + size;
      if (LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', as_int(size), &F(j, j), stride) != 0) return false;
      share_tasks(pieces(height - after), true, [&](Index i) {
        const Index row = after + i * tile;
        divide(F, j, size, row, std::min(tile, height - row));
      });
      const Index wide = pieces(columns - after), high = pieces(height - after);
      share_tasks(wide * high, true, [&](Index i) {
        const Index column = after + i / high * tile, row = after + i % high * tile;
        if (row + tile <= column) return;
        const Index m = std::min(tile, height - row), n = std::min(tile, columns - column);
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, as_int(m), as_int(n), as_int(size), -1.0, &F(row, j), stride,
                    &F(column, j), stride, 1.0, &F(row, column), stride);
      });
    }
    return true;
  }

  // Some rows of F's columns by L_1^-T of these
  static void divide(Matrix& F, Index column, Index columns, Index row, Index rows) {
    if (rows == 0) return;
    cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, as_int(rows), as_int(columns), 1.0,
                &F(column, column), as_int(F.rows()), &F(row, column), as_int(F.rows()));
  }

  // A - L L^T on the lower triangle   (m x m)
  static void subtract_square(const Eigen::Ref<const Matrix>& L, bool share, Matrix& A) {
    const Index m = A.rows(), n = pieces(m);
    const int stride = as_int(L.outerStride()), columns = as_int(L.cols());
    if (!share) {
      cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, as_int(m), columns, -1.0, L.data(), stride, 1.0, A.data(), as_int(m));
      return;
    }
    share_tasks(n * n, true, [&](Index i) {
      const Index column = i / n * tile, row = i % n * tile;
      if (row < column) return;
      const int height = as_int(std::min(tile, m - row)), width = as_int(std::min(tile, m - column));
      if (row == column) {
        cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, width, columns, -1.0, L.data() + row, stride, 1.0, &A(row, row),
                    as_int(m));
      } else {
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, height, width, columns, -1.0, L.data() + row, stride,
                    L.data() + column, stride, 1.0, &A(row, column), as_int(m));
      }
    });
  }

  static Index pieces(Index n) { return (n + tile - 1) / tile; }

  // A supernode's part is a rectangle that begins on the diagonal.
  void store(const Front& front, const Matrix& F, bool alone) {
    const SupernodalFactor& f = factor();
    Index column = 0;
    for (Index s = front.supernode; s < front.supernode + front.n_supernodes; ++s) {
      const Index top = column, height = f.height(s);
      share_columns(f.columns(s), alone, [&](Index j) {
        std::copy_n(F.col(top + j).data() + top, height, x_ + f.px[s] + j * f.stride(s));
      });
      column += f.columns(s);
    }
  }

  double* x_;
};

}  // namespace

Factored factor_supernodes(const SupernodeTree& tree, const ShiftedMatrix& A, double* x, const Progress& progress) {
  return Factoriser(tree, A, x, progress).factor_all();
}

}  // namespace cbr
