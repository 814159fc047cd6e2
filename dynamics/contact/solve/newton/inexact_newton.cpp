// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/newton/inexact_newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "common/base/row_threads.hpp"
#include "common/files/state_archive.hpp"
#include "common/linalg/blas_threads.hpp"
#include "dynamics/contact/solve/newton/closed_unknowns.hpp"
#include "dynamics/contact/solve/newton/krylov.hpp"
#include "dynamics/contact/solve/newton/local_inverse.hpp"

namespace cbr {
namespace {

// Relative residual of a step's linear system. `coarsest` while more than a fraction `most_changes`
// of the points changes state, `coarse` while some do, down to `fine` once none does. Near the
// solution (violation below `near` times the largest |g|) an extra step only to confirm the set
// does not pay.
constexpr double coarsest = 0.1, coarse = 1e-2, fine = 3e-6, most_changes = 0.05, near = 0.03;
// Limit of products per step.
constexpr int most_products = 60;
// Below this fraction of open points reading W itself, in double precision, is cheaper than all
// normal rows.
constexpr double few_open = 0.1;
// Rows from which a second thread pays.
constexpr Index rows_for_threads = 200;
// Single-precision error of gaps, relative to their change.
constexpr double single_precision = 5e-7;
// Recomputes gaps if a violation is at most this multiple of that error, and the error exceeds this
// fraction of the tolerance.
constexpr double most_drift = 20, most_left = 0.1;

}  // namespace

struct InexactNewton::Impl {
  ClosedResponse closed;
  bool stands = false;  // `closed` is valid for this W
  std::optional<Neighbours> neighbours;
  ClosedUnknowns unknowns;
  LocalInverse inverse;
  FloatGmres gmres;
  std::vector<PointState> last;
  // of this Newton step: changes of p and, for active rows, of gap (rows of the problem)
  Vector step, moved;
  Vector scaled;  // over the rows of `closed`
  FloatVector x, b, p_closed, y, normal;
  Eigen::MatrixXf answers;  // to the products of one linear solve

  void begin(const ContactProblem& problem, const ContactSet& set, const Vector& p);
  void join(const ContactProblem& problem, const Vector& g, const Vector& p, Vector& gap,
            ContactSet& set);
  void newton_step(const ContactProblem& problem, const ContactSet& set, const Vector& p,
                   const Vector& gap, double wanted, bool far);
  void solve_linear(double size, float reduction, Vector& change, Vector& answer);
  double float_product(const Vector& change);
  void sum_closed(const ContactProblem& problem, const Vector& g, const Vector& p, Vector& gap);
  void settle(const ContactProblem& problem, const GapsOf& gaps_of, bool off, Vector& p,
              Vector& gap);
  void move_open_points(const ContactProblem& problem, const Vector& change);
  double n_changes(const ContactSet& set) const;
  void fill_moves(const ContactProblem& problem, const Vector& answer, const Vector& change);
};

// Activates points that are not open, or have an impulse that the first step may remove.
void InexactNewton::Impl::begin(const ContactProblem& problem, const ContactSet& set,
                                const Vector& p) {
  if (!neighbours || neighbours->n_points() != problem.n_points()) neighbours.emplace(problem);
  if (!stands) closed.begin(problem);
  stands = true;
  last.clear();
  std::vector<char> wanted(set.states.size(), 0);
  for (Index i = 0; i < problem.n_points(); ++i) {
    const Index first = problem.first[i];
    const bool pushed = !p.segment(first, problem.first[i + 1] - first).isZero(0);
    wanted[i] = problem.w[i] > 0 && (pushed || set.states[i] != PointState::open);
  }
  closed.keep(wanted);
  std::vector<Index> missing;
  for (Index i = 0; i < problem.n_points(); ++i)
    if (wanted[i] && closed.first_row(i) < 0) missing.push_back(i);
  closed.add(problem, missing);
}

// Computes the gaps of all rows of points that close; open ones have a normal gap only.
void InexactNewton::Impl::join(const ContactProblem& problem, const Vector& g, const Vector& p,
                               Vector& gap, ContactSet& set) {
  std::vector<Index> joined;
  for (Index i = 0; i < problem.n_points(); ++i) {
    if (set.states[i] == PointState::open || closed.first_row(i) >= 0 || !(problem.w[i] > 0))
      continue;
    for (Index row = problem.first[i]; row < problem.first[i + 1]; ++row)
      gap[row] = g[row] + problem.W.dense.col(row).dot(p);
    joined.push_back(i);
  }
  if (joined.empty()) return;
  closed.add(problem, joined);
  set = contact_set(problem, p, gap);
}

// gap = g + W p over active rows; other points have no impulse.
void InexactNewton::Impl::sum_closed(const ContactProblem& problem, const Vector& g,
                                     const Vector& p, Vector& gap) {
  std::vector<Index> rows;
  for (const Index point : closed.points())
    for (Index row = problem.first[point];
         closed.first_row(point) >= 0 && row < problem.first[point + 1]; ++row)
      rows.push_back(row);
  const auto n = static_cast<Index>(rows.size());
  if (2 * n > p.size()) {  // most of W is read anyway: in order, by all threads
    const Vector all = respond(problem, p);
    for (const Index row : rows) gap[row] = g[row] + all[row];
    return;
  }
  // Two partial sums of similar size, for any number of threads
  const Vector impulse = p(rows);
  Matrix sums = Matrix::Zero(n, 2);
  const Index middle = static_cast<Index>(0.293 * static_cast<double>(n));
  const int used = n < rows_for_threads ? 1 : std::min(2, n_threads());
  run_kept_threads(used, [&](int t) {
    for (int part = t; part < 2; part += used) {
      double* sum = sums.col(part).data();
      for (Index j = part == 0 ? 0 : middle; j < (part == 0 ? middle : n); ++j) {
        const double* column = problem.W.dense.col(rows[j]).data();
        double own = column[rows[j]] * impulse[j];
        for (Index i = j + 1; i < n; ++i) {
          const double entry = column[rows[i]];
          sum[i] += entry * impulse[j];
          own += entry * impulse[i];
        }
        sum[j] += own;
      }
    }
  });
  for (Index i = 0; i < n; ++i) gap[rows[i]] = g[rows[i]] + (sums(i, 0) + sums(i, 1));
}

// Projects impulses onto the laws' cones, and updates gaps. Recomputes them if `off`, or if open
// points have rows without gaps; otherwise adds the effect of the projection.
void InexactNewton::Impl::settle(const ContactProblem& problem, const GapsOf& gaps_of, bool off,
                                 Vector& p, Vector& gap) {
  const Vector before = p;
  project(problem, p);
  if (off || closed.n_serving() < problem.n_points()) {
    gaps_of(p, gap);
    return;
  }
  Vector change(closed.n_rows());
  for (Index i = 0; i < closed.n_rows(); ++i) {
    const Index row = closed.rows()[i];
    change[i] = (p[row] - before[row]) / closed.scale(i);
  }
  const double unit = float_product(change);
  fill_moves(problem, unit * y.cast<double>(), change);
  gap += moved;
}

// y = s W s change, in units of the returned value.
double InexactNewton::Impl::float_product(const Vector& change) {
  const double size = change.size() > 0 ? change.lpNorm<Eigen::Infinity>() : 0;
  if (!(size > 0) || !std::isfinite(size)) {
    y.setZero(change.size());
    return 0;
  }
  p_closed = (change / size).cast<float>();
  closed.product(p_closed, y);
  return size;
}

// Solves K x = size b; adds C x to `change`, and s W s C x to `answer`.
void InexactNewton::Impl::solve_linear(double size, float reduction, Vector& change,
                                       Vector& answer) {
  const Index n = closed.n_rows();
  inverse.apply(b);
  FloatVector expanded(n);
  if (answers.rows() != n) answers.resize(n, most_products);
  Index products = 0;
  const auto A = [&](const FloatVector& in, FloatVector& out) {
    unknowns.expand(in, expanded);
    closed.product(expanded, y);
    answers.col(products++) = y;
    unknowns.equations(y, in, out);
    inverse.apply(out);
  };
  gmres.solve(A, b, reduction, most_products, x);
  unknowns.expand(x, expanded);
  change += size * expanded.cast<double>();
  y.noalias() = answers.leftCols(gmres.weights().size()) * gmres.weights();
  answer += size * y.cast<double>();
}

// Number of points that changed state since the last step; initially all.
double InexactNewton::Impl::n_changes(const ContactSet& set) const {
  if (last.size() != set.states.size()) return static_cast<double>(set.states.size());
  Index n = 0;
  for (std::size_t i = 0; i < last.size(); ++i) n += last[i] != set.states[i];
  return static_cast<double>(n);
}

// Fills `step` and `moved`. `wanted`: violation after the step relative to that before, for a
// constant set.
void InexactNewton::Impl::newton_step(const ContactProblem& problem, const ContactSet& set,
                                      const Vector& p, const Vector& gap, double wanted, bool far) {
  const Index n = closed.n_rows();
  const double changes = n_changes(set);
  const bool same = changes == 0;
  unknowns.build(problem, set, closed);
  if (!same) inverse.build(closed, unknowns, *neighbours);
  // Change of p by the new set alone: C x_0 - p, x_0 = R^T p
  Vector old(n), change(n);
  for (Index i = 0; i < n; ++i) old[i] = p[closed.rows()[i]] / closed.scale(i);
  const Vector x_0 = unknowns.of_impulses(old);
  unknowns.expand(x_0, change);
  change -= old;
  // r = -R^T (gap + W change) - alpha x_0
  const double unit = float_product(change);
  Vector answer = unit * y.cast<double>();
  scaled.resize(n);
  for (Index i = 0; i < n; ++i) scaled[i] = closed.scale(i) * gap[closed.rows()[i]] + answer[i];
  Vector r;
  unknowns.equations(scaled, x_0, r);
  r = -r;
  const double size = r.size() > 0 ? r.lpNorm<Eigen::Infinity>() : 0;
  x.setZero(r.size());
  if (size > 0 && std::isfinite(size)) {
    b = (r / size).cast<float>();
    const bool moves = far && changes > most_changes * static_cast<double>(problem.n_points());
    const double left = same ? std::clamp(wanted, fine, coarse) : moves ? coarsest : coarse;
    solve_linear(size, static_cast<float>(left), change, answer);
  }
  last = set.states;
  fill_moves(problem, answer, change);
}

// `step` and `moved` from scaled impulse changes and their response, both over the rows of
// `closed`.
void InexactNewton::Impl::fill_moves(const ContactProblem& problem, const Vector& answer,
                                     const Vector& change) {
  step.setZero(problem.n_rows());
  moved.setZero(problem.n_rows());
  for (const Index point : closed.points()) {
    const Index first = closed.first_row(point);
    for (Index d = 0; first >= 0 && d < n_rows(problem.laws[point].law); ++d) {
      const Index i = first + d;
      step[closed.rows()[i]] = closed.scale(i) * change[i];
      moved[closed.rows()[i]] = answer[i] / closed.scale(i);
    }
  }
  move_open_points(problem, change);
}

// Normal gaps of inactive points: by W itself if there are few.
void InexactNewton::Impl::move_open_points(const ContactProblem& problem, const Vector& change) {
  const double size = change.size() > 0 ? change.lpNorm<Eigen::Infinity>() : 0;
  const Index n_open = problem.n_points() - closed.n_serving();
  if (n_open == 0 || !(size > 0) || !std::isfinite(size)) return;
  const bool few = static_cast<double>(n_open) < few_open * static_cast<double>(problem.n_points());
  if (!few) {
    p_closed = (change / size).cast<float>();
    closed.normal_product(problem, p_closed, normal);
  }
  for (Index i = 0; i < problem.n_points(); ++i) {
    if (closed.first_row(i) >= 0 || !(closed.point_scale(i) > 0)) continue;
    const Index row = problem.first[i];
    moved[row] =
        few ? problem.W.dense.col(row).dot(step) : size * normal[i] / closed.point_scale(i);
  }
}

InexactNewton::InexactNewton() : impl_(std::make_unique<Impl>()) {}
InexactNewton::~InexactNewton() = default;
InexactNewton::InexactNewton(InexactNewton&&) noexcept = default;
InexactNewton& InexactNewton::operator=(InexactNewton&&) noexcept = default;

void InexactNewton::forget() {
  impl_->stands = false;
  impl_->neighbours.reset();
  impl_->inverse.forget();
}

void InexactNewton::begin_as(const InexactNewton& other) {
  impl_->neighbours = other.impl_->neighbours;
}

void InexactNewton::keep_state(StateArchive& archive, const ContactProblem& problem) {
  Impl& of = *impl_;
  std::vector<Index> points, serving;
  if (of.stands) points = of.closed.points();  // otherwise of another, perhaps larger W
  for (const Index point : points)
    if (of.closed.first_row(point) >= 0) serving.push_back(point);
  bool has_neighbours = of.neighbours.has_value();
  archive(of.stands, points, serving, has_neighbours);
  if (archive.restores()) {
    of.neighbours.reset();
    if (has_neighbours) of.neighbours.emplace();
    of.closed.begin(problem);
    of.closed.add(problem, points);
    std::vector<char> kept(problem.laws.size(), 0);
    for (const Index point : serving) kept[point] = 1;
    of.closed.keep(kept);
  }
  if (has_neighbours) archive(*of.neighbours);
}

NewtonResult InexactNewton::solve(const ContactProblem& problem, const Vector& g, Vector p,
                                  Vector gap, int max_iterations, double tolerance,
                                  const GapsOf& gaps_of) {
  Impl& of = *impl_;
  NewtonResult best;
  best.p = Vector::Zero(g.size());
  best.gap = g;
  best.residual = std::numeric_limits<double>::infinity();
  ContactSet set = contact_set(problem, p, gap);
  of.begin(problem, set, p);
  const double scale = g.lpNorm<Eigen::Infinity>();
  double drift = 0;  // bound of the error of the gaps
  Vector violations = law_violations(problem, p, gap);
  double merit = violations.norm(), violation = violations.lpNorm<Eigen::Infinity>();
  while (best.iterations < max_iterations && !best.converged) {
    const double enough = std::max(0.5 * tolerance, 0.3 * most_drift * drift);
    of.newton_step(problem, set, p, gap, violation > 0 ? enough / violation : 1.0,
                   violation > near * scale);
    ++best.iterations;
    if (!of.step.allFinite() || !of.moved.allFinite()) break;
    double t = 1, best_t = 1, least = std::numeric_limits<double>::infinity();
    for (; t > 0.01; t /= 2) {
      const double now = law_violations(problem, p + t * of.step, gap + t * of.moved).norm();
      if (now < least) {
        least = now;
        best_t = t;
      }
      if (now <= merit) break;
    }
    p += best_t * of.step;
    gap += best_t * of.moved;
    if (best_t == 1)
      for (Index i = 0; i < problem.n_points(); ++i)
        if (set.states[i] == PointState::open)
          p.segment(problem.first[i], problem.first[i + 1] - problem.first[i]).setZero();
    drift += single_precision * best_t * of.moved.lpNorm<Eigen::Infinity>();
    violations = law_violations(problem, p, gap);
    violation = violations.lpNorm<Eigen::Infinity>();
    if (violation > tolerance && violation <= most_drift * drift && drift > tolerance) {
      of.sum_closed(problem, g, p, gap);
      drift = 0;
      violations = law_violations(problem, p, gap);
    } else if (violation <= std::max(tolerance, most_drift * drift)) {
      of.settle(problem, gaps_of, drift > most_left * tolerance, p, gap);
      drift = 0;
      violations = law_violations(problem, p, gap);
      const double before = best.residual, residual = violations.lpNorm<Eigen::Infinity>();
      if (residual < best.residual) {
        best.p = p;
        best.gap = gap;
        best.residual = residual;
      }
      const double round_off = std::min(gap_round_off(problem, p), 1e4 * tolerance);
      best.converged = residual <= tolerance + round_off ||
                       (residual <= 1e3 * tolerance && residual > 0.3 * before);
    }
    merit = violations.norm();
    violation = violations.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(violation)) break;
    set = contact_set(problem, p, gap);
    of.join(problem, g, p, gap, set);
  }
  return best;
}

}  // namespace cbr
