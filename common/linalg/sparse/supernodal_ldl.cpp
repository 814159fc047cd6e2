// SPDX-License-Identifier: GPL-3.0-or-later

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "common/linalg/sparse/fronts.hpp"

namespace cbr {
namespace {

// Pivots eliminated one by one before a product; columns of a front that are eliminated before the
// next are updated; columns of a product with one triangle of its result.
constexpr Index pivot_block = 32, front_block = 128, update_block = 192;

// Pivots above this share of the matrix' own diagonal enlarge no entry by much.
constexpr double easy_pivot = 0.1;

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

// The same with the largest remaining diagonal entry as pivot, in units of `scale`. order[i]: the
// column of A that is pivot i.
bool eliminate_by_size(Eigen::Ref<Matrix> A, const double* limit, const double* scale,
                       std::vector<Index>& order) {
  const Index n = A.rows();
  Matrix S = A.selfadjointView<Eigen::Lower>();
  for (Index k = 0; k < n; ++k) {
    const auto weight = [&](Index i) { return std::abs(S(i, i)) / scale[order[i]]; };
    Index p = k;
    for (Index i = k + 1; i < n; ++i)
      if (weight(i) > weight(p)) p = i;
    if (p != k) {
      S.row(k).swap(S.row(p));
      S.col(k).swap(S.col(p));
      std::swap(order[k], order[p]);
    }
    const double d = S(k, k);
    if (!(std::abs(d) > limit[order[k]])) return false;
    const Index left = n - k - 1;
    const Vector column = S.col(k).tail(left);
    S.bottomRightCorner(left, left).noalias() -= column / d * column.transpose();
    S.col(k).tail(left) = column / d;
  }
  A.triangularView<Eigen::Lower>() = S;
  return true;
}

// Where L |D|^1/2 and the signs of D go.
struct Kept {
  const Index* px;
  double* x;
  SignedPivots& pivots;
};

class Eliminator final : public Fronts {
 public:
  Eliminator(const SupernodeTree& tree, const ShiftedMatrix& A, double vanishing, const Kept* kept,
             const Progress& progress)
      : Fronts(tree, {A}, tree.factor().n, false, progress), kept_(kept) {
    const SupernodalFactor& f = factor();
    scale_.assign(f.n, 0.0);
    double largest = 0;
    for (Index j = 0; j < f.n; ++j) {
      const Index c = f.order[j];
      double diagonal = 0;
      matrix().each(c, [&](Index row, double value) { diagonal += row == c ? value : 0; });
      scale_[j] = std::abs(diagonal);
      largest = std::max(largest, std::abs(diagonal));
    }
    for (double& scale : scale_) {
      scale = std::max(scale, std::numeric_limits<double>::epsilon() * largest);
      limit_.push_back(vanishing * scale);
    }
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
    if (kept_ != nullptr) keep(front, F, alone);
    return true;
  }

  // A supernode's part is a rectangle that begins on the diagonal.
  void keep(const Front& front, const Matrix& F, bool alone) {
    const SupernodalFactor& f = factor();
    Index column = 0;
    for (Index s = front.supernode; s < front.supernode + front.n_supernodes; ++s) {
      const Index top = column, height = f.height(s);
      kept_->pivots.front_end[s] = front.first + front.columns;
      share_columns(f.columns(s), alone, [&](Index j) {
        const double d = F(top + j, top + j), root = std::sqrt(std::abs(d));
        Eigen::Map<Vector> to(kept_->x + kept_->px[s] + j * height, height);
        to.head(j).setZero();
        to(j) = root;
        to.tail(height - j - 1) = root * F.col(top + j).segment(top + j + 1, height - j - 1);
        kept_->pivots.signs(front.first + top + j) = d < 0 ? -1 : 1;
      });
      column += f.columns(s);
    }
  }

  // In place. Reorders pivots that are small in the given order, as they may be between negative
  // and positive ones. order: empty, or the column that each pivot was.
  bool eliminate_pivots(Eigen::Ref<Matrix> A, Index first, std::vector<Index>& order) {
    const double *limit = limit_.data() + first, *scale = scale_.data() + first;
    const Matrix before = A;
    const auto ratio = [&](Index i) { return std::abs(A(i, i)) / scale[i]; };
    bool is_easy = eliminate_square(A, limit);
    if (A.rows() == 1) return is_easy;
    for (Index i = 0; i < A.rows() && is_easy; ++i) is_easy = ratio(i) > easy_pivot;
    if (is_easy) return true;
    A = before;
    order = first_numbers(A.rows());
    if (!eliminate_by_size(A, limit, scale, order)) return false;
    if (kept_ != nullptr)
      for (std::size_t i = 0; i < order.size(); ++i)
        kept_->pivots.order[static_cast<std::size_t>(first) + i] = first + order[i];
    return true;
  }

  // F = L D over the pivots, block by block: D on the diagonal, L below it, rows on all threads
  // where they share.
  bool eliminate_columns(Index first, Matrix& F, bool share) {
    const Index height = F.rows(), columns = F.cols();
    for (Index j = 0; j < columns; j += front_block) {
      const Index size = std::min(front_block, columns - j), after = j + size;
      // Schur complement of the earlier pivots: A - L (L D)^T
      const Matrix LD = F.block(j, 0, size, j) * F.diagonal().head(j).asDiagonal();
      const auto subtract = [&](Index row, Index rows) {
        if (j > 0)
          F.block(row, j, rows, size).noalias() -= F.block(row, 0, rows, j) * LD.transpose();
      };
      subtract(j, size);
      auto pivots = F.block(j, j, size, size);
      std::vector<Index> order;
      if (!eliminate_pivots(pivots, first + j, order)) return false;
      if (!order.empty())
        F.block(j, 0, size, j) = Matrix(F.block(j, 0, size, j)(order, Eigen::all));
      share_tasks(update_tiles(height - after), share, [&](Index tile) {
        const Index row = after + tile * update_tile, rows = std::min(update_tile, height - row);
        subtract(row, rows);
        auto L = F.block(row, j, rows, size);
        if (!order.empty()) L = Matrix(L(Eigen::all, order));
        divide(pivots, L);
      });
    }
    negative_ += (F.diagonal().array() < 0).count();
    return true;
  }

  const Kept* kept_;
  std::vector<double> scale_, limit_;  // per column in the order of the tree
  std::atomic<Index> negative_{0};
};

}  // namespace

std::optional<Index> count_negative_pivots(const SupernodeTree& tree, const ShiftedMatrix& A,
                                           double vanishing, const Progress& progress) {
  assert(A.K.rows() == tree.factor().n);
  return Eliminator(tree, A, vanishing, nullptr, progress).count();
}

std::optional<Index> factor_with_signs(const SupernodeTree& tree, const ShiftedMatrix& A,
                                       double vanishing, const Index* px, double* x,
                                       SignedPivots& pivots) {
  const SupernodalFactor& f = tree.factor();
  assert(A.K.rows() == f.n);
  pivots.signs.resize(f.n);
  pivots.order = first_numbers(f.n);
  pivots.front_end.resize(f.n_super);
  const Kept kept{px, x, pivots};
  return Eliminator(tree, A, vanishing, &kept, {}).count();
}

}  // namespace cbr
