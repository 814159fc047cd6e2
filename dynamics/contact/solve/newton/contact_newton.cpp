// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/newton/contact_newton.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "common/files/state_archive.hpp"
#include "dynamics/contact/solve/newton/kept_factor.hpp"

namespace cbr {

namespace {

// Largest number of rows for a factor of a set that has not changed: 1.2 GB, and the time of two or
// three Krylov solves.
constexpr std::size_t largest_kept_factor = 12000;
// Closed rows of a dense W up to which a factor, which is exact, costs no more than Krylov
// products.
constexpr std::size_t cheap_factor = 256;
// Impulses outside of the cones are projected, with a product, if they violate the laws by at most
// this number of tolerances.
constexpr double nearly = 1e6;

}  // namespace

struct ContactNewton::Impl {
  // While nothing slides: the state of one of the two factors below.
  std::vector<PointState> held;
  std::optional<SetMatrix> matrix;
  // dense, regular; if not `adapted`, of a set near `held`
  KeptFactor factor;
  bool adapted = false;
  LinearSolver kind = LinearSolver::factor;
  std::vector<PointState> settled;  // at the end of the last solve
  std::vector<PointState> last;     // of the last step
  std::vector<Index> rows;
  Vector b, x;

  // Factors a set that a whole solve has not changed: it is likely to stay.
  LinearSolver choice(const ContactProblem& problem, const ContactSet& set,
                      LinearSolver wanted) const {
    if (problem.W.is_sparse) return wanted;
    if (rows.size() <= cheap_factor) return LinearSolver::factor;
    return set.states == settled && set.states.size() <= largest_kept_factor ? LinearSolver::factor
                                                                             : wanted;
  }

  Vector step(const ContactProblem& problem, const ContactSet& set, const Vector& g,
              const Vector& p, LinearSolver linear) {
    // Coarse while the set changes; Newton's convergence is quadratic once it is fixed
    const double reduction = set.states == last ? 1e-8 : 1e-3;
    last = set.states;
    if (set.slides_anywhere()) return SetMatrix(problem, set, linear).solve(g, p, reduction);
    const bool same = held == set.states;
    if (same && adapted) return solve_kept(g);
    if (!problem.W.is_sparse) closed_rows(problem, set);
    const LinearSolver chosen = choice(problem, set, linear);
    if (same && matrix && (kind == LinearSolver::factor || chosen != LinearSolver::factor))
      return matrix->solve(g, p, reduction);
    held = set.states;
    if (!problem.W.is_sparse) {
      adapted = (chosen == LinearSolver::factor || factor.is_near(rows)) &&
                factor.adapt(problem.W.dense, rows);
      if (adapted) {
        matrix.reset();
        return solve_kept(g);
      }
    }
    matrix.emplace(problem, set, chosen);
    kind = chosen;
    return matrix->solve(g, p, reduction);
  }

  void closed_rows(const ContactProblem& problem, const ContactSet& set) {
    rows.clear();
    for (Index i = 0; i < problem.n_points(); ++i) {
      const Index first = problem.first[i], n = set.states[i] == PointState::open    ? 0
                                                : set.states[i] == PointState::stick ? 3
                                                                                     : 1;
      for (Index d = 0; d < n; ++d)
        if (problem.diagonal[first + d] > 0) rows.push_back(first + d);
    }
  }

  Vector solve_kept(const Vector& g) {
    Vector p = Vector::Zero(g.size());
    b = -g(rows);
    factor.solve(b, x);
    p(rows) = x;
    return p;
  }
};

ContactNewton::ContactNewton() : impl_(std::make_unique<Impl>()) {}
ContactNewton::~ContactNewton() = default;
ContactNewton::ContactNewton(ContactNewton&&) noexcept = default;
ContactNewton& ContactNewton::operator=(ContactNewton&&) noexcept = default;

namespace {

// Projects p onto the cones and keeps it if it is the best so far.
double keep_best(const ContactProblem& problem, const Vector& g, const Vector& p, const Vector& gap,
                 NewtonResult& best) {
  Vector inside = p;
  project(problem, inside);
  Vector inside_gap = inside == p ? gap : Vector(g + respond(problem, inside));
  const double residual = law_violations(problem, inside, inside_gap).lpNorm<Eigen::Infinity>();
  if (residual < best.residual) {
    best.p = std::move(inside);
    best.gap = std::move(inside_gap);
    best.residual = residual;
  }
  return residual;
}

// Line search over p + t (target - p), t = 1, 1/2, .. 1/64, for the least violation of the laws;
// gaps are linear in t.
void line_search(const ContactProblem& problem, const Vector& target, const Vector& target_gap,
                 double enough, Vector& p, Vector& gap) {
  double best = std::numeric_limits<double>::infinity(), best_t = 1;
  for (double t = 1; t > 0.01; t /= 2) {
    const double merit =
        law_violations(problem, p + t * (target - p), gap + t * (target_gap - gap)).norm();
    if (merit < best) {
      best = merit;
      best_t = t;
    }
    if (merit <= enough) break;
  }
  gap += best_t * (target_gap - gap);
  p += best_t * (target - p);
}

}  // namespace

bool ContactNewton::standing_impulses(const ContactProblem& problem, const Vector& g, Vector& p) {
  if (!impl_->adapted || impl_->last != impl_->held) return false;
  p = impl_->solve_kept(g);
  Vector inside = p;
  project(problem, inside);
  return inside == p;
}

NewtonResult ContactNewton::solve_standing(const ContactProblem& problem, const Vector& g,
                                           double tolerance) {
  NewtonResult result;
  if (!impl_->adapted || impl_->last != impl_->held) return result;
  result.p = impl_->solve_kept(g);
  result.gap = g + respond(problem, result.p);
  result.iterations = 1;
  result.outside = result.p;
  project(problem, result.p);
  result.residual = law_violations(problem, result.outside, result.gap).lpNorm<Eigen::Infinity>();
  result.converged =
      result.outside == result.p && result.residual <= tolerance + gap_round_off(problem, result.p);
  return result;
}

// A SetMatrix is a function of W and the set, the factor depends on earlier updates.
void ContactNewton::keep_state(StateArchive& archive, const ContactProblem& problem) {
  Impl& of = *impl_;
  bool has_matrix = of.matrix.has_value();
  archive(of.held, of.factor, of.adapted, of.kind, of.settled, of.last, of.rows, has_matrix);
  if (!archive.restores()) return;
  of.matrix.reset();
  if (has_matrix)
    of.matrix.emplace(problem, ContactSet{of.held, Points::Zero(problem.n_points(), 3)}, of.kind);
}

NewtonResult ContactNewton::solve(const ContactProblem& problem, const Vector& g, Vector p,
                                  Vector gap, LinearSolver linear, int max_iterations,
                                  double tolerance) {
  NewtonResult best;
  best.p = Vector::Zero(g.size());
  best.gap = g;
  best.residual = std::numeric_limits<double>::infinity();
  std::vector<std::vector<PointState>> seen;
  // of the least violation among impulses before projection
  Vector outside, outside_gap;
  double least = std::numeric_limits<double>::infinity();
  double merit = law_violations(problem, p, gap).norm();
  while (best.iterations < max_iterations && !best.converged) {
    const ContactSet set = contact_set(problem, p, gap);
    const bool slides = set.slides_anywhere();
    // Without sliding the set determines the step: a repeated set is a cycle
    if (!slides && linear == LinearSolver::factor &&
        std::find(seen.begin(), seen.end(), set.states) != seen.end())
      break;
    if (!slides) seen.push_back(set.states);
    const Vector target = impl_->step(problem, set, g, p, linear);
    ++best.iterations;
    if (!target.allFinite()) break;
    const Vector target_gap = g + respond(problem, target);
    const double before = best.residual;
    double residual = law_violations(problem, target, target_gap).lpNorm<Eigen::Infinity>();
    if (residual <= nearly * tolerance) {
      residual = keep_best(problem, g, target, target_gap, best);
    } else if (residual < least) {
      least = residual;
      outside = target;
      outside_gap = target_gap;
    }
    const double round_off = std::min(gap_round_off(problem, target), 1e4 * tolerance);
    if (!slides) impl_->settled = set.states;
    best.converged = residual <= tolerance + round_off ||
                     (residual <= 1e3 * tolerance && residual > 0.3 * before);
    if (slides) {
      line_search(problem, target, target_gap, merit, p, gap);
      merit = law_violations(problem, p, gap).norm();
    } else {
      p = target;
      gap = target_gap;
      merit = std::numeric_limits<double>::infinity();
    }
  }
  if (!best.converged && outside.size() > 0) keep_best(problem, g, outside, outside_gap, best);
  if (!(best.residual < std::numeric_limits<double>::infinity()))
    keep_best(problem, g, Vector::Zero(g.size()), g, best);
  return best;
}

}  // namespace cbr
