// SPDX-License-Identifier: GPL-3.0-or-later

#include <cblas.h>
#include <lapacke.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/huge_pages.hpp"
#include "common/linalg/sparse/fronts.hpp"

namespace cbr {
namespace {

class Factoriser final : public Fronts {
 public:
  Factoriser(const SupernodeTree& tree, const SparseMatrix& A, Index boundary, double* x,
             const Progress& progress)
      : Fronts(tree, {{A}}, boundary, false, progress), n_pivots_(tree.factor().n), x_(x) {}
  Factoriser(const SupernodeTree& tree, Index n_pivots, const SparseMatrix& K,
             const SparseMatrix& M, double* x, std::vector<Matrix*> condensed,
             const Progress& progress)
      : Fronts(tree, {{K}, {M}}, n_pivots, true, progress),
        n_pivots_(n_pivots),
        x_(x),
        condensed_(std::move(condensed)) {}

  bool is_done(bool one_by_one = false) { return run(one_by_one) == Outcome::done; }

  // After fronts that were eliminated one by one: of the first pivot that is not positive.
  Index failed() const { return failed_; }

 private:
  bool eliminate(const Front& front, std::vector<FrontMatrix>& of, bool alone) override {
    if (front.is_kept) {
      collect(front, of, alone);
      return true;
    }
    Matrix& F = of.front().F;
    const Index wrong = alone ? (factor_columns(F) ? 0 : 1) : own_columns(F);
    if (wrong > 0) {
      failed_ = front.first + wrong - 1;
      return false;
    }
    if (front.below() > 0) subtract_square(F.bottomRows(front.below()), alone, of.front().rest);
    store(front, F, alone);
    if (of.size() > 1 && front.below() > 0) condense_mass(front, F, alone, of.back());
    return true;
  }

  // Stores the final columns of C.
  void collect(const Front& front, const std::vector<FrontMatrix>& of, bool alone) {
    for (std::size_t a = 0; a < of.size(); ++a) {
      share_columns(front.columns, alone, [&](Index j) {
        for (Index i = j; i < front.height; ++i)
          (*condensed_[a])(front.rows[i] - n_pivots_, front.first + j - n_pivots_) = of[a].F(i, j);
      });
    }
  }

  // With F = [L_1; L_2] and the mass [E; G]: W = L_2 L_1^-1 overwrites L_2. -W^T are the pivots'
  // displacements due to the rows below. T^T M T subtracts W Y^T + Y W^T from the mass of these
  // rows, Y = G - W E / 2 (below x columns).
  static void condense_mass(const Front& front, Matrix& F, bool alone, FrontMatrix& mass) {
    const Index columns = front.columns, below = front.below();
    const int p = as_int(columns), height = as_int(front.height), m = as_int(below);
    share_tasks(alone ? update_tiles(below) : 1, alone, [&](Index i) {
      const Index row = columns + i * update_tile;
      const int rows = alone ? as_int(std::min(update_tile, front.height - row)) : m;
      cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasNoTrans, CblasNonUnit, rows, p, 1.0,
                  F.data(), height, &F(row, 0), height);
      cblas_dsymm(CblasColMajor, CblasRight, CblasLower, rows, p, -0.5, mass.F.data(), height,
                  &F(row, 0), height, 1.0, &mass.F(row, 0), height);
    });
    subtract_pair(F.bottomRows(below), mass.F.bottomRows(below), alone, mass.rest);
  }

  // F_1 = L_1 L_1^T, L_2 = F_2 L_1^-T. The number, from 1, of the pivot that is not positive, or 0.
  static Index own_columns(Matrix& F) {
    const Index height = F.rows(), columns = F.cols();
    const Index wrong =
        LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', as_int(columns), F.data(), as_int(height));
    if (wrong != 0 || height == columns) return wrong;
    cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit,
                as_int(height - columns), as_int(columns), 1.0, F.data(), as_int(height),
                &F(columns, 0), as_int(height));
    return 0;
  }

  // A supernode's part is a rectangle that begins on the diagonal.
  void store(const Front& front, const Matrix& F, bool alone) {
    const SupernodalFactor& f = factor();
    Index column = 0;
    for (Index s = front.supernode; s < front.supernode + front.n_supernodes; ++s) {
      const Index top = column, height = f.height(s);
      share_columns(f.columns(s), alone, [&](Index j) {
        double* to = x_ + f.px[s] + j * f.stride(s);
        std::fill_n(to, j, 0.0);
        std::copy_n(F.col(top + j).data() + top + j, height - j, to + j);
      });
      column += f.columns(s);
    }
  }

  Index n_pivots_;
  std::atomic<Index> failed_{0};
  double* x_;
  std::vector<Matrix*> condensed_;  // of K and M
};

}  // namespace

Index factor_supernodes(const SupernodeTree& tree, const SparseMatrix& A, Index boundary, double* x,
                        const Progress& progress) {
  if (Factoriser(tree, A, boundary, x, progress).is_done()) return A.rows();
  Factoriser again(tree, A, boundary, x, {});
  return again.is_done(true) ? A.rows() : again.failed();
}

bool factor_and_condense(const SupernodeTree& tree, Index n_I, const SparseMatrix& K,
                         const SparseMatrix& M, double* x, Matrix& K_cc, Matrix& M_cc,
                         const Progress& progress) {
  const Index c = tree.factor().n - n_I;
  K_cc = zeros_on_huge_pages(c, c);
  M_cc = zeros_on_huge_pages(c, c);
  return Factoriser(tree, n_I, K, M, x, {&K_cc, &M_cc}, progress).is_done();
}

double condensing_flops(double columns, double below) {
  return 3 * columns * columns * below + 2 * columns * below * below;
}

}  // namespace cbr
