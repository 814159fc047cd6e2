// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/fronts.hpp"

#include <algorithm>
#include <utility>

#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/huge_pages.hpp"

namespace cbr {
namespace {

// Flops of a front, or of all, from which on several threads have enough to do.
constexpr double worth_threads = 2e7;

// Supernodes whose rows are those of the next one and their own columns are one front: the pieces
// of a wide one among them.
std::vector<Front> fronts_of(const SupernodeTree& tree, Index boundary, bool keeps_last) {
  const SupernodalFactor& f = tree.factor();
  std::vector<Front> fronts;
  std::vector<Index> front_of(f.n_super), above;
  for (Index s = 0; s < f.n_super; ++s) {
    const bool goes_on = s > 0 && tree.parent(s - 1) == s &&
                         f.height(s) == f.height(s - 1) - f.columns(s - 1) &&
                         f.first(s) != boundary;
    if (goes_on) {
      fronts.back().columns += f.columns(s);
      ++fronts.back().n_supernodes;
      above.back() = tree.parent(s);
    } else {
      fronts.push_back({f.first(s), f.columns(s), f.height(s), f.rows + f.pi[s], -1, s, 1,
                        keeps_last && f.first(s) >= boundary});
      above.push_back(tree.parent(s));
    }
    front_of[s] = static_cast<Index>(fronts.size()) - 1;
  }
  for (std::size_t i = 0; i < fronts.size(); ++i)
    if (above[i] >= 0) fronts[i].parent = front_of[above[i]];
  return fronts;
}

double flops_of(const Front& front) {
  if (front.is_kept) return 0;
  const auto height = static_cast<double>(front.height), below = static_cast<double>(front.below());
  return (height * height * height - below * below * below) / 3;
}

}  // namespace

Fronts::Fronts(const SupernodeTree& tree, std::vector<ShiftedMatrix> matrices, Index boundary,
               bool keeps_last, const Progress& progress)
    : f_(tree.factor()),
      fronts_(fronts_of(tree, boundary, keeps_last)),
      matrices_(std::move(matrices)),
      place_(static_cast<std::size_t>(f_.n)),
      updates_(fronts_.size()),
      progress_(progress) {
  for (Index j = 0; j < f_.n; ++j) place_[f_.order[j]] = j;
  children_.resize(fronts_.size());
  for (Index s = 0; s < n_fronts(); ++s)
    if (const Index parent = fronts_[s].parent; parent >= 0) children_[parent].push_back(s);
}

Fronts::Outcome Fronts::run(bool one_by_one) {
  runs_ = std::this_thread::get_id();
  for (const Front& front : fronts_) all_flops_ += flops_of(front);
  if (one_by_one || all_flops_ < worth_threads) {
    subtrees_.push_back({0, n_fronts() - 1});
  } else {
    plan();
  }
  const SingleThreadedBlas blas;
  std::vector<Index> position(f_.n, -1);
  std::size_t subtree = 0;
  for (const Index s : top_) {
    // Only the subtrees below it first: updates that wait for a parent use memory
    std::size_t last = subtree;
    while (last < subtrees_.size() && subtrees_[last].last < s) ++last;
    eliminate_subtrees(subtree, last);
    subtree = last;
    if (!fine()) break;
    const Front& next = fronts_[s];
    front(s, position, next.is_kept || flops_of(next) > worth_threads);
  }
  eliminate_subtrees(subtree, subtrees_.size());
  if (foreign_) return Outcome::foreign;
  return stopped_ ? Outcome::stopped : Outcome::done;
}

void Fronts::eliminate_subtrees(std::size_t first, std::size_t last) {
  if (first == last) return;
  std::atomic<std::size_t> next{first};
  const std::size_t threads =
      std::min<std::size_t>(static_cast<std::size_t>(n_threads()), last - first);
  run_threads(static_cast<int>(threads), [&](int) {
    std::vector<Index> position(f_.n, -1);
    for (std::size_t i = next++; i < last && fine(); i = next++)
      for (Index s = subtrees_[i].first; s <= subtrees_[i].last && fine(); ++s)
        front(s, position, false);
  });
}

// In postorder a subtree is a range of fronts that ends with its root.
void Fronts::plan() {
  std::vector<double> work(fronts_.size(), 0.0);
  std::vector<Index> first(work.size());
  double total = 0;
  for (Index s = 0; s < n_fronts(); ++s) {
    const auto i = static_cast<std::size_t>(s);
    const double own = flops_of(fronts_[i]);
    total += own;
    work[i] += own;
    first[i] = s;
    for (const Index child : children_[i]) {
      work[i] += work[child];
      first[i] = std::min(first[i], first[child]);
    }
  }
  const double most = total / 8;
  for (Index s = 0; s < n_fronts(); ++s) {
    const auto i = static_cast<std::size_t>(s);
    if (work[i] > most) {
      top_.push_back(s);
    } else if (fronts_[i].parent < 0 || work[fronts_[i].parent] > most) {
      subtrees_.push_back({first[i], s});
    }
  }
  Index covered = static_cast<Index>(top_.size());
  for (const Subtree& subtree : subtrees_) covered += subtree.last - subtree.first + 1;
  if (covered == n_fronts()) return;
  // Not in postorder after all: one after another, as children always come before their parents.
  subtrees_.clear();
  top_ = first_numbers(fronts_.size());
}

// The frontal matrices, their pivots eliminated; their Schur complements wait for the parent.
void Fronts::front(Index s, std::vector<Index>& position, bool alone) {
  const Front& own = fronts_[s];
  for (Index i = 0; i < own.height; ++i) position[own.rows[i]] = i;
  std::vector<FrontMatrix> of;
  for (const ShiftedMatrix& A : matrices_) {
    of.push_back({on_huge_pages(own.height, own.columns), on_huge_pages(own.below(), own.below())});
    share_columns(own.columns, alone,
                  [&](Index j) { of.back().F.col(j).tail(own.height - j).setZero(); });
    share_columns(own.below(), alone,
                  [&](Index j) { of.back().rest.col(j).tail(own.below() - j).setZero(); });
    assemble(A, own.first, position, of.back().F);
  }
  for (const Index child : children_[s]) extend_add(child, position, alone, of);
  for (Index i = 0; i < own.height; ++i) position[own.rows[i]] = -1;
  if (!fine()) return;
  if (!eliminate(own, of, alone)) {
    stopped_ = true;
    return;
  }
  for (FrontMatrix& matrix : of)
    if (own.below() > 0) updates_[s].push_back(std::move(matrix.rest));
  const double done = done_flops_ += flops_of(own);
  if (progress_ && std::this_thread::get_id() == runs_) progress_(done / all_flops_);
}

void Fronts::assemble(const ShiftedMatrix& A, Index first, const std::vector<Index>& position,
                      Matrix& F) {
  for (Index j = 0; j < F.cols(); ++j) {
    const Index column = first + j;
    A.each(f_.order[column], [&](Index row, double value) {
      const Index place = place_[row];
      if (place < column || value == 0) return;
      const Index i = position[place];
      if (i < 0) {
        foreign_ = true;
      } else {
        F(i, j) += value;
      }
    });
  }
}

void Fronts::extend_add(Index child, const std::vector<Index>& position, bool alone,
                        std::vector<FrontMatrix>& of) {
  const std::vector<Matrix> updates = std::move(updates_[child]);
  updates_[child].clear();
  const Front& from = fronts_[child];
  const Index* rows = from.rows + from.columns;
  const Index columns = of.front().F.cols(), m = from.below();
  std::vector<Index> to(m);
  for (Index i = 0; i < m; ++i) to[i] = position[rows[i]];
  for (std::size_t a = 0; a < updates.size(); ++a) {
    const Matrix& U = updates[a];
    share_columns(m, alone, [&](Index j) {
      const Index column = to[j];
      double* into = column < columns ? of[a].F.col(column).data()
                                      : of[a].rest.col(column - columns).data() - columns;
      for (Index i = j; i < m; ++i) into[to[i]] += U(i, j);
    });
  }
}

double front_bytes(const SupernodeTree& tree) {
  // Columns of a product with one triangle of its result
  constexpr double update_block = 192;
  const std::vector<Front> fronts = fronts_of(tree, tree.factor().n, false);
  std::vector<double> waiting(fronts.size(), 0.0);  // updates of the children
  double held = 0, most = 0;
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    const auto columns = static_cast<double>(fronts[s].columns),
               below = static_cast<double>(fronts[s].below());
    const double update = 8 * below * below;
    most = std::max(most, held + update + 8 * (columns + below + update_block) * columns);
    held += update - waiting[s];
    if (fronts[s].parent >= 0) waiting[fronts[s].parent] += update;
  }
  return most;
}

}  // namespace cbr
