// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/basic_impulses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/linalg/dense.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {
namespace {

// of W scaled to a unit diagonal: below, a row depends on the others
constexpr double weakest_pivot = 1e-10;
constexpr double shift = 1e-8;  // stands in for what is singular; taken back by refinement
constexpr int spreads = 20;
constexpr Index most_pushed = 500;  // each costs what the others are squared

// The pushed points, and the Cholesky factor of W over them, scaled to a unit diagonal.
class Pushed {
 public:
  Pushed(const Matrix& W, const Vector& scale) : W_(W), scale_(scale), L_(64, 64) {}

  Index size() const { return static_cast<Index>(rows_.size()); }
  const std::vector<Index>& rows() const { return rows_; }

  // y with W_PP y = w_Pj, scaled; true when row j is independent of them: it has been added.
  bool add(Index j, Vector& y) {
    const Index n = size();
    if (n == L_.rows()) L_.conservativeResize(2 * n, 2 * n);
    y.resize(n);
    for (Index i = 0; i < n; ++i) y[i] = entry(rows_[static_cast<std::size_t>(i)], j);
    solve_lower(L_, n, y.data());
    const double pivot = 1 - y.squaredNorm();
    if (pivot > weakest_pivot) {
      L_.row(n).head(n) = y.transpose();
      L_(n, n) = std::sqrt(pivot);
      rows_.push_back(j);
      return true;
    }
    solve_lower_transposed(L_, n, y.data());
    singular_ = true;
    return false;
  }
  bool singular() const { return singular_; }

  // All rows again, without those of `gone` (by position); a row that now depends on the others
  // goes too.
  void remove(const std::vector<char>& gone) {
    const std::vector<Index> before = rows_;
    rows_.clear();
    Vector y;
    for (std::size_t i = 0; i < before.size(); ++i)
      if (gone[i] == 0) add(before[i], y);
  }

  // W_PP x = b, scaled.
  Vector solve(Vector b) const {
    solve_lower(L_, size(), b.data());
    solve_lower_transposed(L_, size(), b.data());
    return b;
  }

 private:
  double entry(Index i, Index j) const { return scale_[i] * W_(i, j) * scale_[j]; }

  const Matrix& W_;
  const Vector& scale_;
  Matrix L_;
  std::vector<Index> rows_;
  bool singular_ = false;
};

// One solve: x = p / scale, r = scale gap.
class ActiveSet {
 public:
  ActiveSet(const ContactProblem& problem, const Vector& g)
      : W_(problem.W.dense),
        g_(g),
        scale_(scale_of(problem)),
        x_(Vector::Zero(g.size())),
        gap_(g),
        pushed_(W_, scale_) {}

  const Vector& gap() const { return gap_; }
  Vector impulses() const { return scale_.cwiseProduct(x_); }

  bool singular() const { return pushed_.singular(); }

  bool run(double tolerance, int most, int& steps) {
    start(tolerance);
    while (steps < most && pushed_.size() < most_pushed) {
      const Index j = worst(tolerance);
      if (j < 0) return true;
      ++steps;
      Vector y;
      if (!pushed_.add(j, y) && !exchange(j, y)) return false;
      settle();
      gap_ = g_ + symmetric_product(W_, impulses());
    }
    return false;
  }

 private:
  // All that are closed by then, as far as they are independent: settle() lets go those that would
  // pull.
  void start(double tolerance) {
    std::vector<Index> order;
    for (Index i = 0; i < g_.size(); ++i)
      if (scale_[i] > 0 && g_[i] < -tolerance) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](Index a, Index b) {
      const double of_a = scale_[a] * g_[a], of_b = scale_[b] * g_[b];
      return of_a != of_b ? of_a < of_b : a < b;
    });
    Vector unused;
    for (const Index i : order)
      if (pushed_.size() < most_pushed) pushed_.add(i, unused);
    settle();
    gap_ = g_ + symmetric_product(W_, impulses());
  }

  static Vector scale_of(const ContactProblem& problem) {
    Vector scale = Vector::Zero(problem.n_rows());
    for (Index i = 0; i < scale.size(); ++i)
      if (problem.diagonal[i] > 0) scale[i] = 1 / std::sqrt(problem.diagonal[i]);
    return scale;
  }

  // The point that is not pushed and farthest below 0, as its own impulse sees it.
  Index worst(double tolerance) const {
    Index j = -1;
    double least = 0;
    std::vector<char> is_pushed(static_cast<std::size_t>(g_.size()), 0);
    for (const Index i : pushed_.rows()) is_pushed[static_cast<std::size_t>(i)] = 1;
    for (Index i = 0; i < g_.size(); ++i) {
      if (is_pushed[static_cast<std::size_t>(i)] != 0 || !(scale_[i] > 0) || gap_[i] >= -tolerance)
        continue;
      if (scale_[i] * gap_[i] < least) {
        least = scale_[i] * gap_[i];
        j = i;
      }
    }
    return j;
  }

  // Row j is that of y pushed ones together: pushing j more and them y less moves nothing, until
  // one of them pushes no more.
  bool exchange(Index j, const Vector& y) {
    double step = std::numeric_limits<double>::infinity();
    Index leaves = -1;
    for (Index i = 0; i < y.size(); ++i) {
      if (!(y[i] > 0)) continue;
      const double t = x_[pushed_.rows()[static_cast<std::size_t>(i)]] / y[i];
      if (t < step) {
        step = t;
        leaves = i;
      }
    }
    if (leaves < 0) return false;  // nothing holds against it: no impulse opens all gaps
    for (Index i = 0; i < y.size(); ++i) {
      double& x = x_[pushed_.rows()[static_cast<std::size_t>(i)]];
      x = i == leaves ? 0 : std::max(0.0, x - step * y[i]);
    }
    x_[j] = step;
    std::vector<char> gone(static_cast<std::size_t>(y.size()), 0);
    gone[static_cast<std::size_t>(leaves)] = 1;
    pushed_.remove(gone);
    Vector unused;
    if (!pushed_.add(j, unused)) x_[j] = 0;
    return true;
  }

  // Pushed gaps to 0, or as far towards it as no point pulls, which then is pushed no more.
  void settle() {
    while (pushed_.size() > 0) {
      const std::vector<Index>& rows = pushed_.rows();
      const auto n = static_cast<Index>(rows.size());
      const Vector target = pushed_.solve(-Vector(scale_(rows)).cwiseProduct(Vector(g_(rows))));
      double step = 1;
      for (Index i = 0; i < n; ++i) {
        const double now = x_[rows[static_cast<std::size_t>(i)]];
        if (!(target[i] > 0)) step = std::min(step, now > 0 ? now / (now - target[i]) : 0.0);
      }
      std::vector<char> gone(rows.size(), 0);
      bool any = false;
      Vector x = Vector::Zero(x_.size());
      for (Index i = 0; i < n; ++i) {
        const double now = x_[rows[static_cast<std::size_t>(i)]],
                     next = now + step * (target[i] - now);
        const bool stays = step == 1 || target[i] > 0 || next > 1e-14 * now;
        gone[static_cast<std::size_t>(i)] = stays ? 0 : 1;
        any = any || !stays;
        x[rows[static_cast<std::size_t>(i)]] = stays ? std::max(0.0, next) : 0;
      }
      x_ = std::move(x);
      if (!any) return;
      pushed_.remove(gone);
    }
  }

  const Matrix& W_;
  const Vector& g_;
  Vector scale_, x_, gap_;
  Pushed pushed_;
};

// Least impulses that close `rows`; empty when they do not.
Vector least_impulses(const ContactProblem& problem, const Vector& g,
                      const std::vector<Index>& rows, double tolerance) {
  const Matrix W = problem.W.dense(rows, rows);
  const Vector s = W.diagonal().cwiseSqrt().cwiseInverse(), b = -s.cwiseProduct(Vector(g(rows)));
  Matrix K = s.asDiagonal() * W * s.asDiagonal();
  K.diagonal().array() += shift;
  const Cholesky factor(K);
  if (!factor.ok()) return {};
  K.diagonal().array() -= shift;
  Vector x = factor.solve(b), r = b - K * x;
  for (int i = 0; i < 20 && r.cwiseQuotient(s).lpNorm<Eigen::Infinity>() > 0.1 * tolerance; ++i) {
    x += factor.solve(r);
    r = b - K * x;
  }
  Vector p = Vector::Zero(g.size());
  p(rows) = s.cwiseProduct(x);
  return p;
}

// From the set of closed gaps, without those that would pull.
bool spread(const ContactProblem& problem, const Vector& g, double tolerance, Vector& p,
            Vector& gap) {
  std::vector<Index> rows;
  for (Index i = 0; i < g.size(); ++i)
    if (problem.diagonal[i] > 0 && (p[i] > 0 || gap[i] <= 10 * tolerance)) rows.push_back(i);
  for (int i = 0; i < spreads && !rows.empty(); ++i) {
    Vector least = least_impulses(problem, g, rows, tolerance);
    if (least.size() == 0) return false;
    std::vector<Index> pushing;
    for (const Index row : rows)
      if (least[row] > 0) pushing.push_back(row);
    if (pushing.size() == rows.size()) {
      const Vector new_gap = g + respond(problem, least);
      if (law_violations(problem, least, new_gap).lpNorm<Eigen::Infinity>() > 10 * tolerance)
        return false;
      p = std::move(least);
      gap = new_gap;
      return true;
    }
    rows = std::move(pushing);
  }
  return false;
}

}  // namespace

BasicImpulses basic_impulses(const ContactProblem& problem, const Vector& g, double tolerance) {
  BasicImpulses result;
  ActiveSet set(problem, g);
  result.found = set.run(tolerance, static_cast<int>(3 * g.size()) + 30, result.steps);
  result.p = set.impulses();
  result.gap = set.gap();
  result.singular = set.singular();
  if (result.found) spread(problem, g, tolerance, result.p, result.gap);
  return result;
}

}  // namespace cbr
