// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/shared_solve.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/linalg/kernels/narrow_product.hpp"
#include "common/linalg/sparse/supernodal.hpp"

namespace cbr {
namespace {

// Loads are even when the largest exceeds their mean by no more than this. The part that all
// threads solve together needs more steps, which limits its fraction of the work.
constexpr double even_enough = 1.05, most_at_top = 0.9;
constexpr std::size_t most_subtrees = 256;
// Columns of a supernode that one thread solves for while the others wait: some microseconds.
constexpr Index shared_block = 4 * SupernodeTree::tile;
// Entries of L that are worth a piece of work of their own: ten microseconds.
constexpr double worth_a_piece = 32768;

// Owner of each subtree: the largest goes to the thread with the least load.
std::vector<int> dealt(const std::vector<Index>& subtrees, const std::vector<double>& work,
                       std::vector<double>& loads) {
  std::fill(loads.begin(), loads.end(), 0.0);
  std::vector<std::size_t> order(subtrees.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto work_of = [&](std::size_t i) { return work[subtrees[i]]; };
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
  const SupernodalFactor& f = tree.factor();
  Index longest = SupernodeTree::tile;
  for (Index s = 0; s < f.n_super; ++s) longest = std::max(longest, f.height(s));
  for (int t = 0; t < threads; ++t) {
    panels_.emplace_back(Matrix::Zero(narrow::width, f.n));
    solvers_.emplace_back(tree, narrow::width);
    scratch_.emplace_back(narrow::width, longest);
  }
  plan();
}

// Moves roots of subtrees to the top, the largest first, until the rest divides evenly.
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
      work[tree_.parent(s)] += work[i];
      children[tree_.parent(s)].push_back(s);
    }
  }
  const double total = std::accumulate(own.begin(), own.end(), 0.0);
  std::vector<double> loads(threads_);
  std::vector<int> given = dealt(subtrees, work, loads);
  double top = 0;
  while (!subtrees.empty() && subtrees.size() < most_subtrees) {
    const double mean = (total - top) / threads_;
    if (*std::max_element(loads.begin(), loads.end()) <= even_enough * mean) break;
    const auto largest = std::max_element(subtrees.begin(), subtrees.end(),
                                          [&](Index a, Index b) { return work[a] < work[b]; });
    const Index root = *largest;
    const auto i = static_cast<std::size_t>(root);
    if (top + own[i] > most_at_top * total) break;
    top += own[i];
    subtrees.erase(largest);
    subtrees.insert(subtrees.end(), children[i].begin(), children[i].end());
    given = dealt(subtrees, work, loads);
  }
  std::vector<int> owner(n, -1);
  for (std::size_t i = 0; i < subtrees.size(); ++i) owner[subtrees[i]] = given[i];
  // Parents come after their children
  for (std::size_t i = n; i-- > 0;)
    for (const Index child : children[i])
      if (owner[i] >= 0) owner[child] = owner[i];
  collect(owner);
}

// The sets of supernodes, -1 being the top's.
void SharedSolve::collect(const std::vector<int>& owner) {
  for (std::size_t i = 0; i < owner.size(); ++i) {
    if (owner[i] < 0) {
      top_.push_back(static_cast<Index>(i));
    } else {
      own_[owner[i]].supernodes.push_back(static_cast<Index>(i));
    }
  }
}

double SharedSolve::entries(Index s) const {
  const SupernodalFactor& f = tree_.factor();
  const auto columns = static_cast<double>(f.columns(s)), height = static_cast<double>(f.height(s));
  return columns * (height - columns / 2);
}

// Of the top's supernodes in their order, so many that they have `least` entries together.
std::vector<SharedSolve::Run> SharedSolve::runs(double least) const {
  std::vector<Run> made;
  double sum = least;
  for (std::size_t i = 0; i < top_.size(); ++i) {
    if (sum >= least) {
      made.push_back({i, i});
      sum = 0;
    }
    made.back().last = i + 1;
    sum += entries(top_[i]);
  }
  return made;
}

// The steps of every solve, in their order.
void SharedSolve::plan() {
  const std::vector<Run> parts = runs(4 * worth_a_piece);
  for (std::size_t t = 0; t < own_.size(); ++t) work_.add([this, t](int) { begin(t); });
  work_.next_phase();
  for (const Run& run : parts) work_.add([this, run](int) { gather(run); });
  for (const Index s : top_) plan_forward(s);
  for (auto s = top_.rbegin(); s != top_.rend(); ++s) plan_backward(*s);
  work_.next_phase();
  for (std::size_t t = 0; t < own_.size(); ++t) work_.add([this, t](int) { end(t); });
  for (const Run& run : parts)
    work_.add([this, run](int) {
      for (std::size_t i = run.first; i < run.last; ++i) store(top_[i], main());
    });
}

// Blocks of columns, and their updates of the rows below.
void SharedSolve::plan_forward(Index s) {
  const SupernodalFactor& f = tree_.factor();
  const Index columns = f.columns(s), height = f.height(s);
  const bool is_small = entries(s) < worth_a_piece;
  for (Index first = 0; first < columns; first += shared_block) {
    const Index last = std::min(first + shared_block, columns), after = height - last;
    const auto rows = [this, s, first, last](Index begin, Index end, int thread) {
      narrow::subtract_rows(tree_.factor(), s, first, last, begin, end, main().data(),
                            scratch(thread));
    };
    work_.next_phase();
    work_.add([this, s, first, last, height, is_small, rows](int thread) {
      narrow::solve_columns(tree_, s, first, last, main().data(), scratch(thread));
      if (is_small && last < height) rows(last, height, thread);
    });
    if (is_small || after == 0) continue;
    work_.next_phase();
    const auto pieces =
        static_cast<Index>(1 + static_cast<double>((last - first) * after) / worth_a_piece);
    for (Index i = 0; i < pieces; ++i) {
      const Index begin = last + after * i / pieces, end = last + after * (i + 1) / pieces;
      work_.add([rows, begin, end](int thread) { rows(begin, end, thread); });
    }
  }
}

void SharedSolve::plan_backward(Index s) {
  const SupernodalFactor& f = tree_.factor();
  const Index columns = f.columns(s), height = f.height(s);
  const bool is_small = entries(s) < worth_a_piece;
  for (Index first = (columns - 1) / shared_block * shared_block; first >= 0;
       first -= shared_block) {
    const Index last = std::min(first + shared_block, columns), after = height - last;
    const auto subtract = [this, s, last, height](Index begin, Index end, int thread) {
      apply_signs(tree_.factor().first(s) + begin, end - begin, main());
      narrow::subtract_rows_transposed(tree_.factor(), s, begin, end, last, height, main().data(),
                                       scratch(thread));
    };
    work_.next_phase();
    if (!is_small && after > 0) {
      const auto pieces =
          static_cast<Index>(1 + static_cast<double>((last - first) * after) / worth_a_piece);
      const Index of_all = narrow::width * pieces,
                  width = narrow::width * ((last - first + of_all - 1) / of_all);
      for (Index begin = first; begin < last; begin += width) {
        const Index end = std::min(begin + width, last);
        work_.add([subtract, begin, end](int thread) { subtract(begin, end, thread); });
      }
      work_.next_phase();
    }
    const bool is_left = is_small || after == 0;
    work_.add([this, s, first, last, is_left, subtract](int thread) {
      if (is_left) subtract(first, last, thread);
      narrow::solve_columns_transposed(tree_, s, first, last, main().data(), scratch(thread));
    });
  }
}

void SharedSolve::load(Index s, Matrix& X_t, bool add) const {
  const SupernodalFactor& f = tree_.factor();
  for (Index j = f.first(s); j < f.first(s) + f.columns(s); ++j) {
    if (!add) X_t.col(j).setZero();
    for (Index c = 0; c < columns_; ++c) X_t(c, j) += X_[f.order[j] + c * stride_];
  }
}

void SharedSolve::store(Index s, const Matrix& X_t) {
  const SupernodalFactor& f = tree_.factor();
  for (Index j = f.first(s); j < f.first(s) + f.columns(s); ++j)
    for (Index c = 0; c < columns_; ++c) X_[f.order[j] + c * stride_] = X_t(c, j);
}

void SharedSolve::apply_signs(Index first, Index columns, Matrix& X_t) const {
  if (signs_.size() == 0) return;
  for (Index j = first; j < first + columns; ++j)
    if (signs_(j) < 0) X_t.col(j) = -X_t.col(j);
}

// A thread's subtrees, and their updates of the rows above them.
void SharedSolve::begin(std::size_t t) {
  const SupernodalFactor& f = tree_.factor();
  Matrix& X_t = panels_[t];
  for (const Index s : top_) X_t.middleCols(f.first(s), f.columns(s)).setZero();
  for (const Index s : own_[t].supernodes) load(s, X_t, false);
  solvers_[t].forward(X_t, own_[t]);
  for (const Index s : own_[t].supernodes) apply_signs(f.first(s), f.columns(s), X_t);
}

void SharedSolve::end(std::size_t t) {
  const SupernodalFactor& f = tree_.factor();
  Matrix& X_t = panels_[t];
  if (t > 0)
    for (const Index s : top_)
      X_t.middleCols(f.first(s), f.columns(s)) = main().middleCols(f.first(s), f.columns(s));
  solvers_[t].backward(X_t, own_[t]);
  for (const Index s : own_[t].supernodes) store(s, X_t);
}

// Sums the threads' updates of rows of the top, in the threads' order.
void SharedSolve::gather(const Run& run) {
  const SupernodalFactor& f = tree_.factor();
  for (std::size_t i = run.first; i < run.last; ++i) {
    const Index s = top_[i];
    auto sum = main().middleCols(f.first(s), f.columns(s));
    for (std::size_t t = 1; t < panels_.size(); ++t)
      sum += panels_[t].middleCols(f.first(s), f.columns(s));
    load(s, main(), true);
  }
}

void SharedSolve::operator()(Eigen::Ref<Matrix> X) {
  X_ = X.data();
  stride_ = X.outerStride();
  columns_ = X.cols();
  work_.run(threads_);
}

}  // namespace cbr
