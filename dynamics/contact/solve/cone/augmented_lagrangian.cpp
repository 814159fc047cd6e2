// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/cone/augmented_lagrangian.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cbr {
namespace {

constexpr int inner_steps = 30, most_idle = 20;
// Beyond the largest sigma round-off of y is worth more than what it gains.
constexpr double growth = 10, largest_sigma = 1e5, least_sigma = 1e-3;
// Of the violation that p's last change stands for: what y may leave.
constexpr double share_left = 0.1;
constexpr double shortest_step = 0.003, least_descent = 0.01, round_off = 3e-15;

using Flat = Eigen::Map<const Vector>;
Flat flat(const Points& p) { return {p.data(), p.size()}; }

class Dual {
 public:
  Dual(const ConeProblem& cones, const Points& g, const Points& p, double sigma)
      : cones_(cones), shifted_(p - sigma * g), sigma_(sigma), H_(cones.n_points()) {}

  // From y; true when solved as far as this p asks for.
  bool solve(const Points& p, Vector& y, int most_steps, int& steps) {
    Points Ly = product(y);
    double size = evaluate(y, Ly);
    for (int i = 0; i < most_steps; ++i) {
      ++steps;
      linearise();
      const ConeSystem system(cones_, H_);
      if (!system.ok()) return false;
      const Vector dy = system.solve(Points::Zero(tau_.rows(), 3), R_);
      if (!dy.allFinite()) return false;
      const Points Ldy = product(dy);
      double best = std::numeric_limits<double>::infinity(), best_t = 0;
      for (double t = 1; t > shortest_step; t /= 2) {
        const double now = evaluate(y + t * dy, Ly + t * Ldy);
        if (now < best) {
          best = now;
          best_t = t;
        }
        if (now <= (1 - least_descent * t) * size) break;
      }
      if (!(best < (1 - 1e-6) * size)) return size <= floor(y);
      y += best_t * dy;
      Ly = product(y);
      size = evaluate(y, Ly);
      if (size <= std::max(floor(y), share_left * (next_ - p).norm() / sigma_)) return true;
    }
    return false;
  }

  const Points& next() const { return next_; }

 private:
  Points product(const Vector& y) const {
    Points result(cones_.n_points(), 3);
    Eigen::Map<Vector>(result.data(), result.size()).noalias() = cones_.L * y;
    return result;
  }
  double floor(const Vector& y) const {
    return std::max(1e-13, round_off * sigma_ * (1 + y.norm()));
  }

  double evaluate(const Vector& y, const Points& Ly) {
    tau_ = shifted_ - sigma_ * Ly;
    next_ = tau_;
    project(cones_, next_);
    R_ = y - cones_.L.transpose() * flat(next_);
    return R_.norm();
  }

  void linearise() {
    for (Index i = 0; i < tau_.rows(); ++i) {
      H_[i].setZero();
      if (cones_.moves[i] != 0) H_[i] = sigma_ * projection_derivative(cones_, i, tau_.row(i));
    }
  }

  const ConeProblem& cones_;
  const Points shifted_;
  double sigma_;
  Points tau_, next_;
  Vector R_;
  std::vector<Matrix3> H_;
};

}  // namespace

AugmentedLagrangian augmented_lagrangian(const ConeProblem& cones, const ConeGaps& gaps, Points p,
                                         double sigma, int most_steps, double tolerance) {
  project(cones, p);
  AugmentedLagrangian result{p, violation(cones, gaps, p), 0};
  Vector y = cones.L.transpose() * flat(p);
  double now = result.violation, last = now;  // last: of the best when it was halved last
  int idle = 0;
  while (result.steps < most_steps && result.violation > tolerance && sigma > least_sigma &&
         idle < most_idle) {
    Dual problem(cones, gaps.g, p, sigma);
    int steps = 0;
    const bool ok = problem.solve(p, y, std::min(inner_steps, most_steps - result.steps), steps);
    result.steps += steps;
    const Points next = problem.next();
    const double after = violation(cones, gaps, next);
    if (after < result.violation) {
      result.p = next;
      result.violation = after;
    }
    if (sigma == largest_sigma) ++idle;
    if (result.violation < 0.5 * last) {
      last = result.violation;
      idle = 0;
    }
    if (ok || after < 0.5 * now) {
      p = next;
      now = after;
      if (ok && steps <= inner_steps / 2) sigma = std::min(largest_sigma, sigma * growth);
    } else {
      sigma /= std::sqrt(growth);
      y = cones.L.transpose() * flat(p);
    }
  }
  return result;
}

}  // namespace cbr
