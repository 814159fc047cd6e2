// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/cone/cone_impulses.hpp"

#include <limits>
#include <utility>

#include "dynamics/contact/solve/cone/augmented_lagrangian.hpp"
#include "dynamics/contact/solve/cone/interior_point.hpp"
#include "dynamics/contact/solve/cone/proximal_newton.hpp"

namespace cbr {
namespace {

constexpr double path_tolerance = 1e-8, newton_tolerance = 1e-11, first_epsilon = 1e-7,
                 first_sigma = 1;
constexpr int newton_steps = 30, warm_steps = 8, last_steps = 150;
constexpr double relaxed = 5;  // not worth another attempt

struct Attempts {
  const ContactProblem& problem;
  const ConeProblem& cones;
  const ConeGaps& gaps;
  const Vector& g;
  double tolerance;
  ConeImpulses& best;
  Points best_scaled;

  // True when that is enough.
  bool finish(const Points& start, NewtonStart kind, int most_steps) {
    const ProximalNewton end =
        proximal_newton(cones, gaps, start, first_epsilon, most_steps, newton_tolerance, kind);
    best.steps += end.steps;
    return offer(end.p);
  }

  bool offer(const Points& scaled_p) {
    Vector p = unscaled(problem, cones, gaps, scaled_p);
    project(problem, p);
    Vector gap = g + respond(problem, p);
    const double residual = law_violations(problem, p, gap).lpNorm<Eigen::Infinity>();
    if (residual < best.residual) {
      best.p = std::move(p);
      best.gap = std::move(gap);
      best.residual = residual;
      best_scaled = scaled_p;
    }
    return best.residual <= tolerance;
  }
};

}  // namespace

ConeImpulses cone_impulses(const ContactProblem& problem, const ConeProblem& cones, const Vector& g,
                           const Vector& guess, double tolerance) {
  const ConeGaps gaps = cone_gaps(problem, cones, g);
  ConeImpulses best;
  Attempts attempts{problem, cones, gaps, g, tolerance, best, Points::Zero(cones.n_points(), 3)};
  best.p = Vector::Zero(g.size());
  best.gap = g;
  best.residual = law_violations(problem, best.p, g).lpNorm<Eigen::Infinity>();
  if (guess.size() == g.size() && !guess.isZero(0) &&
      attempts.finish(scaled(problem, cones, gaps, guess), NewtonStart::uncertain, warm_steps))
    return best;
  attempts.tolerance *= relaxed;
  const InteriorPoint path = interior_point(cones, gaps, path_tolerance);
  best.steps += path.steps;
  if (attempts.finish(path.p, NewtonStart::near, newton_steps)) return best;
  const AugmentedLagrangian end = augmented_lagrangian(cones, gaps, attempts.best_scaled,
                                                       first_sigma, last_steps, newton_tolerance);
  best.steps += end.steps;
  attempts.offer(end.p);
  return best;
}

}  // namespace cbr
