// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/newton/contact_newton.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "common/files/state_archive.hpp"

namespace cbr {

namespace {

// Largest number of rows for a factor of a set that has not changed, or for the inverse: 1.2 GB.
// The factor takes the time of two or three Krylov solves.
constexpr std::size_t largest_kept_factor = 12000;
// Closed rows of a dense W up to which a factor, which is exact, costs no more than Krylov
// products.
constexpr std::size_t cheap_factor = 256;
// Rows of an inverse that costs as much as a product.
constexpr std::size_t rows_a_product = 3;
// Impulses outside of the cones are projected, with a product, if they violate the laws by at most
// this number of tolerances.
constexpr double nearly = 1e6;

}  // namespace

struct ContactNewton::Impl {
  std::vector<PointState> held;  // while nothing slides: the set of `matrix`
  std::optional<SetMatrix> matrix;
  LinearSolver kind = LinearSolver::factor;
  std::vector<PointState> settled;  // at the end of the last solve
  std::vector<PointState> last;     // of the last step
  std::optional<FullInverse> inverse;
  Index products = 0;  // of W, by Krylov methods

  // Factors a set that a whole solve has not changed: it is likely to stay.
  LinearSolver choice(const ContactProblem& problem, const ContactSet& set,
                      LinearSolver wanted) const {
    if (problem.W.is_sparse) return wanted;
    std::size_t rows = 0;
    for (const PointState state : set.states)
      if (state != PointState::open) rows += state == PointState::stick ? 3 : 1;
    if (rows <= cheap_factor) return LinearSolver::factor;
    return set.states == settled && set.states.size() <= largest_kept_factor ? LinearSolver::factor
                                                                             : wanted;
  }

  // Whether `inverse` serves the set. It is made once products have cost as much.
  bool has_inverse(const ContactProblem& problem, const ContactSet& set) {
    const auto rows = static_cast<std::size_t>(problem.n_rows());
    if (rows > static_cast<std::size_t>(products) * rows_a_product || rows > largest_kept_factor)
      return false;
    if (!FullInverse::serves(problem, set)) return false;
    if (!inverse) inverse.emplace(problem);
    return inverse->ok();
  }

  Vector step(const ContactProblem& problem, const ContactSet& set, const Vector& g,
              const Vector& p, const Vector& gap, LinearSolver linear) {
    // Coarse while the set changes; Newton's convergence is quadratic once it is fixed
    const double reduction = set.states == last ? 1e-8 : 1e-3;
    last = set.states;
    const bool iterates = linear == LinearSolver::krylov && !problem.W.is_sparse;
    if (iterates && has_inverse(problem, set)) return inverse->solve(problem, set, p, gap);
    if (set.slides_anywhere())
      return SetMatrix(problem, set, linear).solve(g, p, reduction, &products);
    const LinearSolver chosen = choice(problem, set, linear);
    const bool serves = matrix && held == set.states &&
                        (kind == LinearSolver::factor || chosen != LinearSolver::factor);
    if (!serves) {
      held = set.states;
      kind = chosen;
      matrix.emplace(problem, set, kind);
    }
    return matrix->solve(g, p, reduction, &products);
  }

  // Whether there is a factor of the last set.
  bool stands(const ContactProblem& problem) const {
    return matrix && matrix->has_factor() && !problem.W.is_sparse && last == held;
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
  if (!impl_->stands(problem)) return false;
  p = impl_->matrix->solve(g, Vector(), 0);
  Vector inside = p;
  project(problem, inside);
  return inside == p;
}

NewtonResult ContactNewton::solve_standing(const ContactProblem& problem, const Vector& g,
                                           double tolerance) {
  NewtonResult result;
  if (!impl_->stands(problem)) return result;
  result.p = impl_->matrix->solve(g, Vector(), 0);
  result.gap = g + respond(problem, result.p);
  result.iterations = 1;
  result.outside = result.p;
  project(problem, result.p);
  result.residual = law_violations(problem, result.outside, result.gap).lpNorm<Eigen::Infinity>();
  result.converged =
      result.outside == result.p && result.residual <= tolerance + gap_round_off(problem, result.p);
  return result;
}

// A SetMatrix is a function of W and the set.
void ContactNewton::keep_state(StateArchive& archive, const ContactProblem& problem) {
  Impl& of = *impl_;
  bool has_matrix = of.matrix.has_value();
  archive(of.held, of.kind, of.settled, of.last, of.products, has_matrix);
  if (!archive.restores()) return;
  of.inverse.reset();
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
    const Vector target = impl_->step(problem, set, g, p, gap, linear);
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
