// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/local_inverse.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/files/state_archive.hpp"

namespace cbr {
namespace {

// Earlier points in a row of G: more gained nothing (docs/decisions/contact-solver.md).
constexpr std::size_t normal_neighbours = 7, tangential_neighbours = 6;
constexpr Index most_in_block = 2 * (tangential_neighbours + 1);
// Pivots of a block below this share of its diagonal: the row has its diagonal alone then.
constexpr double weakest_pivot = 1e-5;

// a's and b's columns of R over W between their points; both are normal or both tangential.
double between(const ClosedResponse& closed, const ClosedUnknowns::Unknown& a, const ClosedUnknowns::Unknown& b) {
  if (a.c[0] != 0) return closed.entry(a.row, b.row);
  double sum = 0;
  for (Index i = 1; i < 3; ++i) {
    if (a.c[i] == 0) continue;
    for (Index j = 1; j < 3; ++j)
      if (b.c[j] != 0) sum += a.c[i] * b.c[j] * closed.entry(a.row + i, b.row + j);
  }
  return sum;
}

}  // namespace

Neighbours::Neighbours(const ContactProblem& problem) : nearest_(problem.laws.size()) {
  const Index n = problem.n_points();
  const auto count = static_cast<std::size_t>(std::min(most, n - 1));
  std::vector<double> answer(static_cast<std::size_t>(n)), root(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) {
    const double w = problem.diagonal[problem.first[i]];
    root[i] = w > 0 ? 1 / std::sqrt(w) : 0;
  }
  std::vector<Index> order(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) {
    const double* column = problem.W.dense.col(problem.first[i]).data();
    for (Index j = 0; j < n; ++j) answer[j] = j == i ? -HUGE_VAL : std::abs(column[problem.first[j]]) * root[j];
    std::iota(order.begin(), order.end(), Index{0});
    const auto more = [&](Index a, Index b) { return answer[a] != answer[b] ? answer[a] > answer[b] : a < b; };
    const auto last = order.begin() + static_cast<std::ptrdiff_t>(count);
    std::nth_element(order.begin(), last, order.end(), more);
    std::sort(order.begin(), last, more);
    nearest_[i].assign(order.begin(), last);
  }
}

void Neighbours::keep_state(StateArchive& archive) { archive(nearest_); }

// Of the unknowns block_, the last of which is the row's own.
void LocalInverse::add_row(const ClosedResponse& closed, const ClosedUnknowns& unknowns) {
  const Index n = static_cast<Index>(block_.size());
  std::array<std::array<double, most_in_block>, most_in_block> L;
  bool regular = true;
  for (Index j = 0; j < n && regular; ++j) {
    const auto& u = unknowns[block_[j]];
    for (Index k = 0; k <= j; ++k) {
      double sum = between(closed, u, unknowns[block_[k]]);
      if (k == j) sum += u.alpha;
      const double own = sum;
      for (Index l = 0; l < k; ++l) sum -= L[j][l] * L[k][l];
      if (k < j) {
        L[j][k] = sum / L[k][k];
      } else {
        regular = sum > weakest_pivot * own;
        L[j][j] = std::sqrt(regular ? sum : own);
      }
    }
  }
  start_.push_back(static_cast<Index>(column_.size()));
  if (!regular) {
    const auto& u = unknowns[block_.back()];
    const double own = between(closed, u, u) + u.alpha;
    column_.push_back(block_.back()), value_.push_back(own > 0 ? static_cast<float>(1 / std::sqrt(own)) : 1.0F);
    return;
  }
  // L^T y = e_n
  std::array<double, most_in_block> y;
  for (Index j = n - 1; j >= 0; --j) {
    double sum = j == n - 1 ? 1 : 0;
    for (Index k = j + 1; k < n; ++k) sum -= L[k][j] * y[k];
    y[j] = sum / L[j][j];
  }
  for (Index j = 0; j < n; ++j) column_.push_back(block_[j]), value_.push_back(static_cast<float>(y[j]));
}

void LocalInverse::build(const ClosedResponse& closed, const ClosedUnknowns& unknowns, const Neighbours& neighbours) {
  start_.clear(), column_.clear(), value_.clear();
  for (Index i = 0; i < unknowns.size(); ++i) {
    const Index point = unknowns.point(i);
    const bool is_normal = i < unknowns.n_normals();
    const auto range = [&](Index of) { return is_normal ? unknowns.normal(of) : unknowns.tangential(of); };
    const std::size_t wanted = is_normal ? normal_neighbours : tangential_neighbours;
    block_.clear();
    std::size_t found = 0;
    for (const Index other : neighbours.of(point)) {
      if (found == wanted) break;
      const ClosedUnknowns::Range of = range(other);
      if (other > point || of.first == of.last) continue;
      for (Index u = of.first; u < of.last; ++u) block_.push_back(u);
      ++found;
    }
    for (Index u = range(point).first; u <= i; ++u) block_.push_back(u);
    add_row(closed, unknowns);
  }
  start_.push_back(static_cast<Index>(column_.size()));
}

void LocalInverse::apply(FloatVector& x) const {
  const Index n = x.size();
  y_.resize(n);
  for (Index i = 0; i < n; ++i) {
    float sum = 0;
    for (Index k = start_[i]; k < start_[i + 1]; ++k) sum += value_[k] * x[column_[k]];
    y_[i] = sum;
  }
  x.setZero();
  for (Index i = 0; i < n; ++i)
    for (Index k = start_[i]; k < start_[i + 1]; ++k) x[column_[k]] += value_[k] * y_[i];
}

}  // namespace cbr
