// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/cone/proximal_newton.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cbr {
namespace {

constexpr int proximal_steps = 10;
// Of an uncertain start: steps in which the first problem must bring the violation down to this
// share.
constexpr int trial_steps = 3;
constexpr double trial_gain = 0.1;
constexpr double least_epsilon = 1e-9, largest_epsilon = 100;
constexpr double shortest_search = 0.005, least_gain = 0.1;

// One proximal problem: F(p) = p - P(tau), tau = p - u, u = g + W p + epsilon (p - centre); tied: F
// = u.
class Proximal {
 public:
  Proximal(const ConeProblem& cones, const Points& g, const Points& centre, double epsilon)
      : cones_(cones), g_(g - epsilon * centre), epsilon_(epsilon), H_(cones.n_points()) {}

  // p from a start; the norm of F that is left.
  double solve(Points& p, double tolerance, int most_steps, int& steps) {
    u_ = response_gap(cones_, g_, p) + epsilon_ * p;
    double size = evaluate(p, u_);
    for (int i = 0; i < most_steps && size > tolerance; ++i) {
      ++steps;
      if (!direct()) break;
      const Points du = response_gap(cones_, Points::Zero(p.rows(), 3), dp_) + epsilon_ * dp_;
      double best = std::numeric_limits<double>::infinity(), best_t = 0;
      for (double t = 1; t > shortest_search; t /= 2) {
        const double now = evaluate(p + t * dp_, u_ + t * du);
        if (now < best) {
          best = now;
          best_t = t;
        }
        if (now <= (1 - least_gain * t) * size) break;
      }
      if (!(best < std::numeric_limits<double>::infinity())) break;
      p += best_t * dp_;
      u_ = response_gap(cones_, g_, p) + epsilon_ * p;
      size = evaluate(p, u_);
    }
    return size;
  }

 private:
  bool works(Index i) const { return cones_.moves[i] != 0; }

  double evaluate(const Points& p, const Points& u) {
    F_.setZero(p.rows(), 3);
    tau_ = p - u;
    for (Index i = 0; i < p.rows(); ++i) {
      if (!works(i)) continue;
      if (cones_.tied[i] != 0) {
        F_.row(i) = u.row(i);
        continue;
      }
      const double normal = std::max(0.0, tau_(i, 0)), limit = cones_.friction[i] * normal;
      const double length = std::hypot(tau_(i, 1), tau_(i, 2));
      F_(i, 0) = p(i, 0) - normal;
      F_.row(i).tail<2>() =
          p.row(i).tail<2>() - (length > limit ? limit / length : 1.0) * tau_.row(i).tail<2>();
    }
    return F_.norm();
  }

  // dp: F + dF = 0, from A dp + P' L q = -F with A = I - (1 - epsilon) P', q = L^T dp.
  bool direct() {
    Points b = Points::Zero(F_.rows(), 3);
    for (Index i = 0; i < F_.rows(); ++i) {
      H_[i].setZero();
      if (!works(i)) continue;
      const Matrix3 D = projection_derivative(cones_, i, tau_.row(i));
      if (D(0, 0) == 0) {
        b.row(i) = -F_.row(i);
        continue;
      }
      const Matrix3 A = cones_.tied[i] != 0 ? Matrix3(epsilon_ * D)
                                            : Matrix3(Matrix3::Identity() - (1 - epsilon_) * D);
      const Matrix3 inverse = A.inverse();
      b.row(i) = -(inverse * F_.row(i).transpose()).transpose();
      H_[i] = inverse * D;
    }
    const ConeSystem system(cones_, H_);
    if (!system.ok()) return false;
    const Vector change = cones_.L * system.solve(b, Vector::Zero(cones_.rank()));
    if (!change.allFinite()) return false;
    dp_ = b;
    for (Index i = 0; i < F_.rows(); ++i)
      dp_.row(i) -= (H_[i] * change.segment<3>(3 * i)).transpose();
    return dp_.allFinite();
  }

  const ConeProblem& cones_;
  const Points g_;
  double epsilon_;
  Points u_, tau_, F_, dp_;
  std::vector<Matrix3> H_;
};

}  // namespace

ProximalNewton proximal_newton(const ConeProblem& cones, const ConeGaps& gaps, Points p,
                               double epsilon, int most_steps, double tolerance,
                               NewtonStart start) {
  ProximalNewton result{p, violation(cones, gaps, p), 0};
  double now = result.violation, before = std::numeric_limits<double>::infinity();
  while (result.steps < most_steps && result.violation > tolerance) {
    const bool trial = start == NewtonStart::uncertain && result.steps == 0;
    const double aim = std::max(1e-15, 1e-4 * now * epsilon), first = result.violation;
    Points next = p;
    int steps = 0;
    const double left = Proximal(cones, gaps.g, p, epsilon)
                            .solve(next, aim, trial ? trial_steps : proximal_steps, steps);
    result.steps += std::max(1, steps);
    const double after = violation(cones, gaps, next);
    if (after < result.violation) {
      result.p = next;
      result.violation = after;
    }
    if (trial && !(result.violation <= trial_gain * first)) break;
    if (!(result.violation <= 0.5 * before)) break;
    before = first;
    if (left <= 100 * aim || after < 0.5 * now) {
      p = std::move(next);
      now = after;
      epsilon = std::max(least_epsilon, epsilon * (steps <= proximal_steps / 2 + 1 ? 0.1 : 0.5));
    } else {
      epsilon *= 10;
      if (epsilon > largest_epsilon) break;
    }
  }
  return result;
}

}  // namespace cbr
