// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/shared_solve.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/base/row_threads.hpp"
#include "common/linalg/kernels/narrow_product.hpp"

namespace cbr {
namespace {

// Shares are even enough when the largest exceeds their mean by this; no more than this part of the
// work is left to one thread.
constexpr double even_enough = 1.1, most_at_top = 0.3;
constexpr std::size_t most_subtrees = 256;

// The largest to whoever has least; loads: of each thread. Who gets which.
std::vector<int> dealt(const std::vector<Index>& subtrees, const std::vector<double>& work,
                       std::vector<double>& loads) {
  std::fill(loads.begin(), loads.end(), 0.0);
  std::vector<std::size_t> order(subtrees.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto work_of = [&](std::size_t i) { return work[static_cast<std::size_t>(subtrees[i])]; };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return work_of(a) > work_of(b); });
  std::vector<int> owner(subtrees.size());
  for (const std::size_t i : order) {
    const auto least = std::min_element(loads.begin(), loads.end());
    *least += work_of(i);
    owner[i] = static_cast<int>(least - loads.begin());
  }
  return owner;
}

}  // namespace

SharedSolve::SharedSolve(const SupernodeTree& tree, int threads, Vector signs)
    : tree_(tree),
      threads_(threads),
      signs_(std::move(signs)),
      own_(static_cast<std::size_t>(threads)) {
  share_out();
  for (int t = 0; t < threads; ++t) {
    panels_.emplace_back(Matrix::Zero(narrow::width, tree.factor().n));
    solvers_.emplace_back(tree, narrow::width);
  }
}

// Roots of subtrees go to the top, the largest first, until what is left can be shared evenly.
void SharedSolve::share_out() {
  const SupernodalFactor& f = tree_.factor();
  const auto n = static_cast<std::size_t>(f.n_super);
  std::vector<double> own(n), work(n, 0.0);
  std::vector<std::vector<Index>> children(n);
  std::vector<Index> subtrees;
  for (Index s = 0; s < f.n_super; ++s) {
    const auto i = static_cast<std::size_t>(s);
    own[i] = static_cast<double>(f.columns(s) * (2 * f.height(s) - f.columns(s)));
    work[i] += own[i];
    if (tree_.parent(s) < 0) {
      subtrees.push_back(s);
    } else {
      work[static_cast<std::size_t>(tree_.parent(s))] += work[i];
      children[static_cast<std::size_t>(tree_.parent(s))].push_back(s);
    }
  }
  const double total = std::accumulate(own.begin(), own.end(), 0.0);
  std::vector<double> loads(static_cast<std::size_t>(threads_));
  std::vector<int> given = dealt(subtrees, work, loads);
  double top = 0;
  while (!subtrees.empty() && subtrees.size() < most_subtrees) {
    const double mean = (total - top) / threads_;
    if (*std::max_element(loads.begin(), loads.end()) <= even_enough * mean) break;
    const auto largest = std::max_element(subtrees.begin(), subtrees.end(), [&](Index a, Index b) {
      return work[static_cast<std::size_t>(a)] < work[static_cast<std::size_t>(b)];
    });
    const Index root = *largest;
    const auto i = static_cast<std::size_t>(root);
    if (top + own[i] > most_at_top * total) break;
    top += own[i];
    subtrees.erase(largest);
    subtrees.insert(subtrees.end(), children[i].begin(), children[i].end());
    given = dealt(subtrees, work, loads);
  }
  std::vector<int> owner(n, -1);
  for (std::size_t i = 0; i < subtrees.size(); ++i)
    owner[static_cast<std::size_t>(subtrees[i])] = given[i];
  // Parents come after their children
  for (std::size_t i = n; i-- > 0;)
    for (const Index child : children[i])
      if (owner[i] >= 0) owner[static_cast<std::size_t>(child)] = owner[i];
  collect(owner);
}

// The sets of supernodes, -1 being the top's.
void SharedSolve::collect(const std::vector<int>& owner) {
  for (std::size_t i = 0; i < owner.size(); ++i) {
    SupernodeSet& set = owner[i] < 0 ? top_ : own_[static_cast<std::size_t>(owner[i])];
    set.supernodes.push_back(static_cast<Index>(i));
  }
}

void SharedSolve::load(const SupernodeSet& set, const Eigen::Ref<const Matrix>& B, Matrix& X_t,
                       bool add) const {
  const SupernodalFactor& f = tree_.factor();
  for (const Index s : set.supernodes) {
    for (Index j = f.first(s); j < f.first(s) + f.columns(s); ++j) {
      if (!add) X_t.col(j).setZero();
      for (Index c = 0; c < B.cols(); ++c) X_t(c, j) += B(f.order[j], c);
    }
  }
}

void SharedSolve::store(const SupernodeSet& set, const Matrix& X_t, Eigen::Ref<Matrix> B) const {
  const SupernodalFactor& f = tree_.factor();
  for (const Index s : set.supernodes)
    for (Index j = f.first(s); j < f.first(s) + f.columns(s); ++j)
      for (Index c = 0; c < B.cols(); ++c) B(f.order[j], c) = X_t(c, j);
}

void SharedSolve::apply_signs(const SupernodeSet& set, Matrix& X_t) const {
  if (signs_.size() == 0) return;
  const SupernodalFactor& f = tree_.factor();
  for (const Index s : set.supernodes)
    for (Index j = f.first(s); j < f.first(s) + f.columns(s); ++j)
      if (signs_(j) < 0) X_t.col(j) = -X_t.col(j);
}

void SharedSolve::operator()(Eigen::Ref<Matrix> B) {
  const SupernodalFactor& f = tree_.factor();
  const auto for_top = [&](auto work) {
    for (const Index s : top_.supernodes) work(f.first(s), f.columns(s));
  };
  Matrix& main = panels_[0];
  run_kept_threads(threads_, [&](int thread) {
    const auto t = static_cast<std::size_t>(thread);
    Matrix& X_t = panels_[t];
    for_top([&](Index first, Index columns) { X_t.middleCols(first, columns).setZero(); });
    load(own_[t], B, X_t, false);
    solvers_[t].forward(X_t, own_[t]);
    apply_signs(own_[t], X_t);
  });
  // What the subtrees take from the rows above them, in the threads' order
  for (std::size_t t = 1; t < panels_.size(); ++t)
    for_top([&](Index first, Index columns) {
      main.middleCols(first, columns) += panels_[t].middleCols(first, columns);
    });
  load(top_, B, main, true);
  solvers_[0].forward(main, top_);
  apply_signs(top_, main);
  solvers_[0].backward(main, top_);
  store(top_, main, B);
  run_kept_threads(threads_, [&](int thread) {
    const auto t = static_cast<std::size_t>(thread);
    Matrix& X_t = panels_[t];
    if (t > 0)
      for_top([&](Index first, Index columns) {
        X_t.middleCols(first, columns) = main.middleCols(first, columns);
      });
    solvers_[t].backward(X_t, own_[t]);
    store(own_[t], X_t, B);
  });
}

}  // namespace cbr
