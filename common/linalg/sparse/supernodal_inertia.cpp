// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/supernodal_inertia.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>

namespace cbr {
namespace {

// Pivots eliminated one by one before a product takes over; columns of a product with one triangle of its result.
constexpr Index pivot_block = 32, update_block = 192;

// A - L D L^T on the lower triangle of A (m x m), in blocks of columns, which threads share.
void subtract_lower(const Eigen::Ref<const Matrix>& L, const Vector& D, bool share, Matrix& A) {
  const Index m = A.rows(), blocks = (m + update_block - 1) / update_block;
  share_tasks(blocks, share, [&](Index b) {
    const Index j = b * update_block, columns = std::min(update_block, m - j);
    const Matrix W = L.middleRows(j, columns) * D.asDiagonal();
    A.block(j, j, m - j, columns).noalias() -= L.bottomRows(m - j) * W.transpose();
  });
}

// A = L D L^T of a small block, in place: D on the diagonal, L below it. False at a pivot below its limit.
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

class Counter final : public Fronts {
 public:
  Counter(const SupernodeTree& tree, const ShiftedMatrix& A, double vanishing)
      : Fronts(tree, {A}, tree.factor().n) {
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
    for (double& limit : limit_) limit = vanishing * std::max(limit, std::numeric_limits<double>::epsilon() * scale);
  }

  std::optional<Index> count() {
    const Outcome outcome = run();
    if (outcome == Outcome::foreign) return std::nullopt;
    return outcome == Outcome::stopped ? Index{-1} : negative_.load();
  }

 private:
  bool eliminate(const Front& front, std::vector<FrontMatrix>& of, bool alone) override {
    Matrix& F = of.front().F;
    if (!eliminate_columns(front.first, F)) return false;
    if (front.below() > 0) subtract_lower(F.bottomRows(front.below()), F.diagonal(), alone, of.front().rest);
    return true;
  }

  // F = L D over the pivots, block by block: D on the diagonal, L below it.   (height x columns)
  bool eliminate_columns(Index first, Matrix& F) {
    const Index height = F.rows(), columns = F.cols();
    Vector D(columns);
    Matrix W;
    for (Index j = 0; j < columns; j += pivot_block) {
      const Index size = std::min(pivot_block, columns - j), left = height - j - size;
      if (j > 0) {
        // what the pivots before have left: A - L (L D)^T
        W = F.block(j, 0, size, j) * D.head(j).asDiagonal();
        F.block(j, j, height - j, size).noalias() -= F.bottomLeftCorner(height - j, j) * W.transpose();
      }
      auto pivots = F.block(j, j, size, size);
      if (!eliminate_block(pivots, limit_.data() + first + j)) return false;
      D.segment(j, size) = pivots.diagonal();
      if (left > 0) {
        // L <- A L_1^-T D^-1
        auto L = F.block(j + size, j, left, size);
        pivots.triangularView<Eigen::UnitLower>().transpose().solveInPlace<Eigen::OnTheRight>(L);
        L *= D.segment(j, size).cwiseInverse().asDiagonal();
      }
    }
    negative_ += (D.array() < 0).count();
    return true;
  }

  std::vector<double> limit_;  // per pivot
  std::atomic<Index> negative_{0};
};

}  // namespace

std::optional<Index> count_negative_pivots(const SupernodeTree& tree, const ShiftedMatrix& A, double vanishing) {
  assert(A.K.rows() == tree.factor().n);
  return Counter(tree, A, vanishing).count();
}

}  // namespace cbr
