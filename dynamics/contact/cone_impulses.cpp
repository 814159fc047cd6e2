// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/cone_impulses.hpp"

#include <limits>
#include <utility>

#include "dynamics/contact/interior_point.hpp"
#include "dynamics/contact/proximal_newton.hpp"

namespace cbr {
namespace {

constexpr double path_tolerance = 1e-8, further = 1e-12, newton_tolerance = 1e-13, first_epsilon = 1e-7;
constexpr int newton_steps = 30, warm_steps = 8;
constexpr double relaxed = 5;  // not worth another attempt
// Of the last attempt: where W has a long tail of small eigenvalues.
constexpr double last_epsilon = 1e-5;
constexpr int last_steps = 60;

struct Attempts {
  const ContactProblem& problem;
  const ConeProblem& cones;
  const ConeGaps& gaps;
  const Vector& g;
  double tolerance;
  ConeImpulses& best;
  Points best_scaled;

  // True when that is enough.
  bool finish(const Points& start, double epsilon, int most_steps) {
    const ProximalNewton end = proximal_newton(cones, gaps, start, epsilon, most_steps, newton_tolerance);
    best.steps += end.steps;
    Vector p = unscaled(problem, cones, gaps, end.p);
    project(problem, p);
    Vector gap = g + respond(problem, p);
    const double residual = law_violations(problem, p, gap).lpNorm<Eigen::Infinity>();
    if (residual < best.residual) {
      best.p = std::move(p), best.gap = std::move(gap), best.residual = residual;
      best_scaled = end.p;
    }
    return best.residual <= tolerance;
  }
};

}  // namespace

ConeImpulses cone_impulses(const ContactProblem& problem, const ConeProblem& cones, const Vector& g, const Vector& guess,
                           double tolerance) {
  const ConeGaps gaps = cone_gaps(problem, cones, g);
  ConeImpulses best;
  Attempts attempts{problem, cones, gaps, g, tolerance, best, Points::Zero(cones.n_points(), 3)};
  best.p = Vector::Zero(g.size()), best.gap = g;
  best.residual = law_violations(problem, best.p, g).lpNorm<Eigen::Infinity>();
  if (guess.size() == g.size() && !guess.isZero(0) &&
      attempts.finish(scaled(problem, cones, gaps, guess), first_epsilon, warm_steps))
    return best;
  attempts.tolerance *= relaxed;
  for (const SlipDerivative slip : {SlipDerivative::damped, SlipDerivative::lagged, SlipDerivative::whole}) {
    const InteriorPoint path = interior_point(cones, gaps, slip, slip == SlipDerivative::damped ? path_tolerance : further);
    best.steps += path.steps;
    if (attempts.finish(path.p, first_epsilon, newton_steps)) return best;
  }
  attempts.finish(Points(attempts.best_scaled), last_epsilon, last_steps);
  return best;
}

}  // namespace cbr
