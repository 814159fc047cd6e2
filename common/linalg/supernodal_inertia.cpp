// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/supernodal_inertia.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/linalg/blas_threads.hpp"
#include "common/parallel.hpp"
#include "common/program.hpp"

namespace cbr {
namespace {

// Pivots eliminated one by one before a product takes over; columns of a product with one triangle of its result.
constexpr Index pivot_block = 32, update_block = 192;

// A - L D L^T on the lower triangle of A (m x m), in blocks of columns.
void subtract_lower(const Eigen::Ref<const Matrix>& L, const Vector& D, Matrix& A) {
  const Index m = A.rows();
  Matrix W;
  for (Index j = 0; j < m; j += update_block) {
    const Index columns = std::min(update_block, m - j);
    W = L.middleRows(j, columns) * D.asDiagonal();
    A.block(j, j, m - j, columns).noalias() -= L.bottomRows(m - j) * W.transpose();
  }
}

// A = L D L^T of a small block, in place: D on the diagonal, L below it. False at a pivot below its limit.
bool eliminate(Eigen::Ref<Matrix> A, const double* limit) {
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

// Columns that are eliminated together, and the rows that they share.
struct Front {
  Index first = 0, columns = 0, height = 0;
  const Index* rows = nullptr;
  Index parent = -1;  // a front, -1: none
  Index below() const { return height - columns; }
};

// Supernodes whose rows are those of the next one and their own columns are one front: the pieces of a wide one among them.
std::vector<Front> fronts_of(const SupernodeTree& tree) {
  const SupernodalFactor& f = tree.factor();
  std::vector<Front> fronts;
  std::vector<Index> front_of(static_cast<std::size_t>(f.n_super)), above;
  for (Index s = 0; s < f.n_super; ++s) {
    const bool goes_on = s > 0 && tree.parent(s - 1) == s && f.height(s) == f.height(s - 1) - f.columns(s - 1);
    if (goes_on) {
      fronts.back().columns += f.columns(s);
      above.back() = tree.parent(s);
    } else {
      fronts.push_back({f.first(s), f.columns(s), f.height(s), f.rows + f.pi[s], -1});
      above.push_back(tree.parent(s));
    }
    front_of[static_cast<std::size_t>(s)] = static_cast<Index>(fronts.size()) - 1;
  }
  for (std::size_t i = 0; i < fronts.size(); ++i)
    if (above[i] >= 0) fronts[i].parent = front_of[static_cast<std::size_t>(above[i])];
  return fronts;
}

class Counter {
 public:
  Counter(const SupernodeTree& tree, const ShiftedMatrix& A, double vanishing)
      : f_(tree.factor()), fronts_(fronts_of(tree)), A_(A), updates_(fronts_.size()) {
    const auto n = static_cast<std::size_t>(f_.n);
    place_.resize(n);
    limit_.assign(n, 0.0);
    double scale = 0;
    for (Index j = 0; j < f_.n; ++j) {
      const Index c = f_.order[j];
      double diagonal = 0;
      A_.each(c, [&](Index row, double value) { diagonal += row == c ? value : 0; });
      place_[static_cast<std::size_t>(c)] = j;
      limit_[static_cast<std::size_t>(j)] = std::abs(diagonal);
      scale = std::max(scale, std::abs(diagonal));
    }
    for (double& limit : limit_) limit = vanishing * std::max(limit, std::numeric_limits<double>::epsilon() * scale);
    children_.resize(fronts_.size());
    for (Index s = 0; s < n_fronts(); ++s)
      if (fronts_[s].parent >= 0) children_[static_cast<std::size_t>(fronts_[s].parent)].push_back(s);
  }

  std::optional<Index> run() {
    plan();
    std::vector<Index> position(static_cast<std::size_t>(f_.n), -1);
    std::size_t subtree = 0;
    for (const Index s : top_) {
      // The subtrees below it first, and no others: what waits for a parent takes memory
      std::size_t last = subtree;
      while (last < subtrees_.size() && subtrees_[last].last < s) ++last;
      eliminate_subtrees(subtree, last);
      subtree = last;
      // Few and large: here BLAS's own threads have enough to do.
      if (fine()) front(s, position);
    }
    eliminate_subtrees(subtree, subtrees_.size());
    if (foreign_) return std::nullopt;
    return vanished_ ? Index{-1} : negative_.load();
  }

 private:
  struct Subtree {
    Index first, last;
  };

  bool fine() const { return !vanished_ && !foreign_; }
  Index n_fronts() const { return static_cast<Index>(fronts_.size()); }

  void eliminate_subtrees(std::size_t first, std::size_t last) {
    if (first == last) return;
    std::atomic<std::size_t> next{first};
    const SingleThreadedBlas blas;
    run_threads(static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(n_threads()), last - first)), [&](int) {
      std::vector<Index> position(static_cast<std::size_t>(f_.n), -1);
      for (std::size_t i = next++; i < last && fine(); i = next++)
        for (Index s = subtrees_[i].first; s <= subtrees_[i].last && fine(); ++s) front(s, position);
    });
  }

  // In postorder a subtree is a range of fronts that ends with its root.
  void plan() {
    std::vector<double> work(fronts_.size(), 0.0);
    std::vector<Index> first(work.size());
    double total = 0;
    for (Index s = 0; s < n_fronts(); ++s) {
      const auto i = static_cast<std::size_t>(s);
      const auto height = static_cast<double>(fronts_[i].height), below = static_cast<double>(fronts_[i].below());
      const double own = height * height * height - below * below * below;
      total += own;
      work[i] += own;
      first[i] = s;
      for (const Index child : children_[i]) {
        work[i] += work[static_cast<std::size_t>(child)];
        first[i] = std::min(first[i], first[static_cast<std::size_t>(child)]);
      }
    }
    const double most = total / 8;
    for (Index s = 0; s < n_fronts(); ++s) {
      const auto i = static_cast<std::size_t>(s);
      if (work[i] > most) {
        top_.push_back(s);
      } else if (fronts_[i].parent < 0 || work[static_cast<std::size_t>(fronts_[i].parent)] > most) {
        subtrees_.push_back({first[i], s});
      }
    }
    Index covered = static_cast<Index>(top_.size());
    for (const Subtree& subtree : subtrees_) covered += subtree.last - subtree.first + 1;
    if (covered == n_fronts()) return;
    // Not in postorder after all: one after another, as children always come before their parents.
    subtrees_.clear();
    top_.resize(fronts_.size());
    std::iota(top_.begin(), top_.end(), Index{0});
  }

  // The frontal matrix, its pivots eliminated; what is left of it waits for the parent.
  void front(Index s, std::vector<Index>& position) {
    const Front& own = fronts_[static_cast<std::size_t>(s)];
    const Index height = own.height, columns = own.columns, below = own.below();
    const Index* rows = own.rows;
    for (Index i = 0; i < height; ++i) position[static_cast<std::size_t>(rows[i])] = i;
    Matrix F = Matrix::Zero(height, columns), rest = Matrix::Zero(below, below);
    assemble(s, position, F);
    for (const Index child : children_[static_cast<std::size_t>(s)]) extend_add(child, position, F, rest);
    for (Index i = 0; i < height; ++i) position[static_cast<std::size_t>(rows[i])] = -1;
    if (!fine() || !eliminate_columns(own.first, F)) return;
    if (below == 0) return;
    subtract_lower(F.bottomRows(below), F.diagonal(), rest);
    updates_[static_cast<std::size_t>(s)] = std::move(rest);
  }

  void assemble(Index s, const std::vector<Index>& position, Matrix& F) {
    for (Index j = 0; j < F.cols(); ++j) {
      const Index column = fronts_[static_cast<std::size_t>(s)].first + j;
      A_.each(f_.order[column], [&](Index row, double value) {
        const Index place = place_[static_cast<std::size_t>(row)];
        if (place < column || value == 0) return;
        const Index i = position[static_cast<std::size_t>(place)];
        if (i < 0) {
          foreign_ = true;
        } else {
          F(i, j) += value;
        }
      });
    }
  }

  void extend_add(Index child, const std::vector<Index>& position, Matrix& F, Matrix& rest) {
    Matrix U = std::move(updates_[static_cast<std::size_t>(child)]);
    updates_[static_cast<std::size_t>(child)].resize(0, 0);
    const Front& from = fronts_[static_cast<std::size_t>(child)];
    const Index* rows = from.rows + from.columns;
    const Index columns = F.cols(), m = U.rows();
    std::vector<Index> to(static_cast<std::size_t>(m));
    for (Index i = 0; i < m; ++i) to[static_cast<std::size_t>(i)] = position[static_cast<std::size_t>(rows[i])];
    for (Index j = 0; j < m; ++j) {
      const Index column = to[static_cast<std::size_t>(j)];
      double* into = column < columns ? F.col(column).data() : rest.col(column - columns).data() - columns;
      for (Index i = j; i < m; ++i) into[to[static_cast<std::size_t>(i)]] += U(i, j);
    }
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
      if (!eliminate(pivots, limit_.data() + first + j)) {
        vanished_ = true;
        return false;
      }
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

  const SupernodalFactor& f_;
  std::vector<Front> fronts_;  // children before their parents
  ShiftedMatrix A_;
  std::vector<Index> place_;                  // in the order of elimination, of each row of A
  std::vector<double> limit_;                 // per pivot
  std::vector<std::vector<Index>> children_;  // per front, ascending
  std::vector<Matrix> updates_;               // lower triangles
  std::vector<Subtree> subtrees_;
  std::vector<Index> top_;
  std::atomic<Index> negative_{0};
  std::atomic<bool> vanished_{false}, foreign_{false};
};

}  // namespace

std::optional<Index> count_negative_pivots(const SupernodeTree& tree, const ShiftedMatrix& A, double vanishing) {
  assert(A.K.rows() == tree.factor().n);
  return Counter(tree, A, vanishing).run();
}

double front_bytes(const SupernodeTree& tree) {
  const std::vector<Front> fronts = fronts_of(tree);
  std::vector<double> waiting(fronts.size(), 0.0);  // updates of the children
  double held = 0, most = 0;
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    const auto columns = static_cast<double>(fronts[s].columns), below = static_cast<double>(fronts[s].below());
    const double update = 8 * below * below;
    most = std::max(most, held + update + 8 * (columns + below + update_block) * columns);
    held += update - waiting[s];
    if (fronts[s].parent >= 0) waiting[static_cast<std::size_t>(fronts[s].parent)] += update;
  }
  return most;
}

}  // namespace cbr
