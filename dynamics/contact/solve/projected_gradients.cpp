// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/projected_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cbr {
namespace {

// Unit-diagonal scaling; rows that no impulse moves stay out.
Vector unit_scale(const ContactProblem& problem) {
  Vector s = Vector::Zero(problem.n_rows());
  for (Index i = 0; i < s.size(); ++i)
    if (problem.diagonal[i] > 0) s[i] = 1 / std::sqrt(problem.diagonal[i]);
  return s;
}

std::vector<char> bounded_rows(const ContactProblem& problem) {
  std::vector<char> bounded(problem.n_rows(), 0);
  for (Index i = 0; i < problem.n_points(); ++i)
    bounded[problem.first[i]] = problem.laws[i].law == ContactLaw::frictionless;
  return bounded;
}

struct Gradients {
  Vector free, chopped;  // phi, beta
  double reduced = 0;    // phi . min(phi, x / step)
};

// r = A x - b. On a bound: chopped, elsewhere free.
Gradients split(const Vector& r, const Vector& x, const std::vector<char>& bounded, double step) {
  Gradients d{Vector::Zero(r.size()), Vector::Zero(r.size()), 0};
  for (Index i = 0; i < r.size(); ++i) {
    if (!bounded[i] || x[i] > 0) {
      d.free[i] = r[i];
      d.reduced += r[i] * (bounded[i] ? std::min(r[i], x[i] / step) : r[i]);
    } else {
      d.chopped[i] = std::min(0.0, r[i]);
    }
  }
  return d;
}

double feasible_step(const Vector& x, const Vector& direction, const std::vector<char>& bounded) {
  double step = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < x.size(); ++i)
    if (bounded[i] && direction[i] > 0) step = std::min(step, x[i] / direction[i]);
  return step;
}

}  // namespace

double scaled_norm(const ContactProblem& problem) {
  const Vector scale = unit_scale(problem);
  Vector x(problem.n_rows());
  for (Index i = 0; i < x.size(); ++i)
    x[i] = scale[i] > 0 ? 1 + 0.3 * std::sin(static_cast<double>(i)) : 0.0;
  double largest = 1;
  for (int i = 0; i < 12 && x.norm() > 0; ++i) {
    x /= x.norm();
    x = scale.cwiseProduct(respond(problem, scale.cwiseProduct(x)));
    largest = std::max(largest, x.norm());
  }
  return largest;
}

int projected_gradients(const ContactProblem& problem, const Vector& g, double largest,
                        int max_products, double tolerance, Vector& p, Vector& gap) {
  const Vector scale = unit_scale(problem);
  const std::vector<char> bounded = bounded_rows(problem);
  const auto product = [&](const Vector& y) -> Vector {
    return scale.cwiseProduct(respond(problem, scale.cwiseProduct(y)));
  };
  const double expansion = 1.5 / largest;
  // p = scale x, r = scale gap
  Vector x = p, r = scale.cwiseProduct(gap);
  for (Index i = 0; i < x.size(); ++i) x[i] = scale[i] > 0 ? p[i] / scale[i] : 0.0;
  const auto worst = [&] {
    double violation = 0;
    for (Index i = 0; i < x.size(); ++i) {
      if (!(scale[i] > 0)) continue;
      violation =
          std::max(violation, std::abs(bounded[i] ? std::min(x[i], r[i]) : r[i]) / scale[i]);
    }
    return violation;
  };
  Gradients d = split(r, x, bounded, expansion);
  Vector direction = d.free;
  int products = 0;
  while (products < max_products && worst() > tolerance) {
    if (d.chopped.squaredNorm() <= d.reduced) {
      const Vector Ad = product(direction);
      ++products;
      const double curvature = direction.dot(Ad),
                   step = curvature > 0 ? r.dot(direction) / curvature : 0.0;
      const double longest = feasible_step(x, direction, bounded);
      // no bottom: no impulse closes these gaps
      if (!(curvature > 0) && std::isinf(longest)) break;
      if (curvature > 0 && step <= longest) {
        x -= step * direction;
        r -= step * Ad;
        for (Index i = 0; i < x.size(); ++i)
          if (bounded[i] && x[i] < 0) x[i] = 0;
        d = split(r, x, bounded, expansion);
        direction = d.free - (d.free.dot(Ad) / curvature) * direction;
        continue;
      }
      x -= longest * direction;
      r -= longest * Ad;
      const Gradients half = split(r, x, bounded, expansion);
      x -= expansion * half.free;
      for (Index i = 0; i < x.size(); ++i)
        if (bounded[i]) x[i] = std::max(0.0, x[i]);
      r = scale.cwiseProduct(g + respond(problem, scale.cwiseProduct(x)));
      ++products;
    } else {
      const Vector Ad = product(d.chopped);
      ++products;
      const double curvature = d.chopped.dot(Ad);
      if (!(curvature > 0)) break;
      const double step = r.dot(d.chopped) / curvature;
      x -= step * d.chopped;
      r -= step * Ad;
    }
    d = split(r, x, bounded, expansion);
    direction = d.free;
  }
  p = scale.cwiseProduct(x);
  gap = g + respond(problem, p);
  return products + 1;
}

}  // namespace cbr
