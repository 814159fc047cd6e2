// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/supernodal_ldl.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>

namespace cbr {
namespace {

// Pivots eliminated one by one before a product takes over; columns of a front before those after
// them are looked at; columns of a product with one triangle of its result.
constexpr Index pivot_block = 32, front_block = 128, update_block = 192;

// A - L D L^T on the lower triangle of A (m x m), in blocks of columns, which threads share.
void subtract_lower(const Eigen::Ref<const Matrix>& L, const Vector& D, bool share, Matrix& A) {
  const Index m = A.rows(), blocks = (m + update_block - 1) / update_block;
  share_tasks(blocks, share, [&](Index b) {
    const Index j = b * update_block, columns = std::min(update_block, m - j);
    const Matrix W = L.middleRows(j, columns) * D.asDiagonal();
    A.block(j, j, m - j, columns).noalias() -= L.bottomRows(m - j) * W.transpose();
  });
}

// A = L D L^T of a small block, in place: D on the diagonal, L below it. False at a pivot below its
// limit.
bool eliminate_block(Eigen::Ref<Matrix> A, const double* limit) {
  const Index n = A.rows();
  for (Index k = 0; k < n; ++k) {
    const double d = A(k, k);
    if (!(std::abs(d) > limit[k])) return false;
    for (Index j = k + 1; j < n; ++j) {
      const double l = A(j, k) / d;
      for (Index i = j; i < n; ++i) A(i, j) -= l * A(i, k);
    }
    for (Index i = k + 1; i < n; ++i) A(i, k) /= d;
  }
  return true;
}

// L <- A L_1^-T D^-1, L_1 the unit lower triangle of `pivots` and D its diagonal.
void divide(const Eigen::Ref<const Matrix>& pivots, Eigen::Ref<Matrix> L) {
  pivots.triangularView<Eigen::UnitLower>().transpose().solveInPlace<Eigen::OnTheRight>(L);
  L *= pivots.diagonal().cwiseInverse().asDiagonal();
}

// The same of a larger square, a few pivots at a time.
bool eliminate_square(Eigen::Ref<Matrix> A, const double* limit) {
  const Index n = A.rows();
  for (Index j = 0; j < n; j += pivot_block) {
    const Index size = std::min(pivot_block, n - j), after = j + size, left = n - after;
    auto pivots = A.block(j, j, size, size);
    if (!eliminate_block(pivots, limit + j)) return false;
    if (left == 0) break;
    auto L = A.block(after, j, left, size);
    divide(pivots, L);
    const Matrix LD = L * pivots.diagonal().asDiagonal();
    A.block(after, after, left, left).noalias() -= L * LD.transpose();
  }
  return true;
}

class Counter final : public Fronts {
 public:
  Counter(const SupernodeTree& tree, const ShiftedMatrix& A, double vanishing,
          const Progress& progress)
      : Fronts(tree, {A}, tree.factor().n, progress) {
    const SupernodalFactor& f = factor();
    limit_.assign(static_cast<std::size_t>(f.n), 0.0);
    double scale = 0;
    for (Index j = 0; j < f.n; ++j) {
      const Index c = f.order[j];
      double diagonal = 0;
      matrix().each(c, [&](Index row, double value) { diagonal += row == c ? value : 0; });
      limit_[static_cast<std::size_t>(j)] = std::abs(diagonal);
      scale = std::max(scale, std::abs(diagonal));
    }
    for (double& limit : limit_)
      limit = vanishing * std::max(limit, std::numeric_limits<double>::epsilon() * scale);
  }

  std::optional<Index> count() {
    const Outcome outcome = run();
    if (outcome == Outcome::foreign) return std::nullopt;
    return outcome == Outcome::stopped ? Index{-1} : negative_.load();
  }

 private:
  bool eliminate(const Front& front, std::vector<FrontMatrix>& of, bool alone) override {
    Matrix& F = of.front().F;
    if (!eliminate_columns(front.first, F, alone)) return false;
    if (front.below() > 0)
      subtract_lower(F.bottomRows(front.below()), F.diagonal(), alone, of.front().rest);
    return true;
  }

  // F = L D over the pivots, block by block: D on the diagonal, L below it, rows on all threads
  // where they share.
  bool eliminate_columns(Index first, Matrix& F, bool share) {
    const Index height = F.rows(), columns = F.cols();
    for (Index j = 0; j < columns; j += front_block) {
      const Index size = std::min(front_block, columns - j), after = j + size;
      // What the pivots before have left: A - L (L D)^T
      const Matrix LD = F.block(j, 0, size, j) * F.diagonal().head(j).asDiagonal();
      const auto subtract = [&](Index row, Index rows) {
        if (j > 0)
          F.block(row, j, rows, size).noalias() -= F.block(row, 0, rows, j) * LD.transpose();
      };
      subtract(j, size);
      auto pivots = F.block(j, j, size, size);
      if (!eliminate_square(pivots, limit_.data() + first + j)) return false;
      share_tasks(update_tiles(height - after), share, [&](Index tile) {
        const Index row = after + tile * update_tile, rows = std::min(update_tile, height - row);
        subtract(row, rows);
        divide(pivots, F.block(row, j, rows, size));
      });
    }
    negative_ += (F.diagonal().array() < 0).count();
    return true;
  }

  std::vector<double> limit_;  // per pivot
  std::atomic<Index> negative_{0};
};

}  // namespace

std::optional<Index> count_negative_pivots(const SupernodeTree& tree, const ShiftedMatrix& A,
                                           double vanishing, const Progress& progress) {
  assert(A.K.rows() == tree.factor().n);
  return Counter(tree, A, vanishing, progress).count();
}

}  // namespace cbr
