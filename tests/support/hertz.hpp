// SPDX-License-Identifier: GPL-3.0-or-later
// Impact of an elastic ball on an equal ball or a rigid plane: Hertz's closed form, and the
// quasi-static solution of a finite ball.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/fem/elements/element.hpp"

namespace cbr::test {

// SI units. `speed`: of the approach. The ball has all of it on a rigid plane, and half of it on an
// equal ball.
struct BallImpact {
  double radius = 10e-3, speed = 1;
  Material material{210e9, 0.3, 7850};
  bool on_plane = true;

  double ball_mass() const {
    return 4.0 / 3 * std::numbers::pi * std::pow(radius, 3) * material.density;
  }
  // of one ball
  double modulus() const {
    return material.youngs_modulus / (1 - std::pow(material.poissons_ratio, 2));
  }
  // reduced mass
  double mass() const { return on_plane ? ball_mass() : ball_mass() / 2; }
};

struct ImpactAnswer {
  double approach = 0, force = 0, duration = 0,
         contact_radius = 0;          // duration: from first to last touch; the others: maxima
  std::vector<double> time, history;  // force against time from the first touch
  double force_at(double t) const {
    if (t <= time.front() || t >= time.back()) return 0;
    const auto after =
        static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), t) - time.begin());
    const double s = (t - time[after - 1]) / (time[after] - time[after - 1]);
    return (1 - s) * history[after - 1] + s * history[after];
  }
};

// delta = (15 m v^2 / (16 E* sqrt R*))^(2/5), F = 4/3 E* sqrt(R*) delta^(3/2), t = 2.943275 delta /
// v, a = sqrt(R* delta).
inline ImpactAnswer hertz(const BallImpact& impact) {
  const double share = impact.on_plane ? 1 : 0.5, E = share * impact.modulus(),
               R = share * impact.radius;
  ImpactAnswer answer;
  answer.approach =
      std::pow(15 * impact.mass() * impact.speed * impact.speed / (16 * E * std::sqrt(R)), 0.4);
  answer.force = 4.0 / 3 * E * std::sqrt(R) * std::pow(answer.approach, 1.5);
  answer.duration = 2.943275 * answer.approach / impact.speed;
  answer.contact_radius = std::sqrt(R * answer.approach);
  return answer;
}

// Compliance W(a) of a ball: displacement of the centre of mass relative to the contact circle, per
// force F. The circle of radius a has Hertz's pressure, which also weights the mean displacement
// over it. The ball's inertia balances F. By Legendre polynomials: a normal pressure q_n P_n moves
// the surface by c_n q_n P_n (Lurie's solutions of the sphere; c_1 relative to the centre of mass,
// with a uniform body force). A half-space has W = 3 / (5 E* a). The plane's pressure acts along
// the axis and not along the ball's normal. The remaining outward traction q r / R does work on the
// pressure's displacements (half-space, Betti) of -(1 - 2 nu) / (4 pi mu R) F^2 for every a.
inline double ball_compliance(const BallImpact& impact, double a) {
  const double R = impact.radius, nu = impact.material.poissons_ratio,
               mu = impact.material.youngs_modulus / (2 * (1 + nu));
  double W = 0;
  const int last = static_cast<int>(30 * R / a);  // terms decrease as n^-4 beyond R / a
  for (int n = 0; n < last; ++n) {
    const double k = n;
    double c = (4 * (1 - nu) * k * k + 2 * nu * k - 2 + 4 * nu) /
               ((k - 1) * (k * k + k + 1 + (2 * k + 1) * nu));
    if (n == 1) c = 6 * (1 - 2 * nu) / (5 * (1 + nu));
    // P_n component of the pressure, P_n ~ J_0
    const double x = (k + 0.5) * a / R, s = 3 * (std::sin(x) - x * std::cos(x)) / (x * x * x);
    W += R / (4 * mu) * c * (2 * k + 1) / (4 * std::numbers::pi * R * R) * s * s;
  }
  return W - (1 - 2 * nu) / (4 * std::numbers::pi * mu * R);
}

// Quasi-static impact of a finite ball. For a circle of radius a, F and the approach make the
// complementary energy F^2 W(a) / 2 + F (a^2 / 5 R - delta) stationary. Then m delta'' = -F by
// energy. Differs from Hertz by terms of order a / R.
inline ImpactAnswer finite_ball(const BallImpact& impact) {
  const double R = impact.radius, sides = impact.on_plane ? 1 : 2,
               a_hertz = hertz(impact).contact_radius;
  constexpr int n = 150;
  std::vector<double> radius(n + 1, 0.0), force = radius, approach = radius, work = radius;
  for (int i = 1; i <= n; ++i) {
    const double a = 1.2 * a_hertz * i / n, da = 1e-3 * a;
    const double slope =
        (ball_compliance(impact, a + da) - ball_compliance(impact, a - da)) / (2 * da);
    radius[i] = a;
    force[i] = -2 * (2 * a / (5 * R)) / slope;
    approach[i] = sides * (a * a / (5 * R) + force[i] * ball_compliance(impact, a));
    work[i] = i == 1
                  ? 0.4 * force[i] * approach[i]
                  : work[i - 1] + (force[i] + force[i - 1]) / 2 * (approach[i] - approach[i - 1]);
  }
  // Between the points the force varies as (delta - shift)^(3/2), so that powers of it are nearly
  // linear
  const auto interpolate = [&](const std::vector<double>& x, double x_power,
                               const std::vector<double>& y, double y_power, double x_at) {
    const auto i = std::clamp<std::size_t>(
        static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), x_at) - x.begin()), 1, n);
    const auto u = [&](double value) { return std::pow(value, x_power); };
    const auto v = [&](double value) { return std::pow(value, y_power); };
    return std::pow(
        v(y[i - 1]) + (u(x_at) - u(x[i - 1])) / (u(x[i]) - u(x[i - 1])) * (v(y[i]) - v(y[i - 1])),
        1 / y_power);
  };
  const double energy = impact.mass() * impact.speed * impact.speed / 2;
  ImpactAnswer answer;
  answer.approach = interpolate(work, 0.4, approach, 1, energy);
  answer.force = interpolate(approach, 1, force, 2.0 / 3, answer.approach);
  answer.contact_radius = interpolate(approach, 1, radius, 2, answer.approach);
  // delta = delta_max (1 - s^2) removes the root of the speed from the integral of dt = d delta /
  // speed
  constexpr int steps = 4000;
  std::vector<double> t(1, 0.0), F(1, answer.force);  // backwards from the largest approach
  for (int i = 0; i < steps; ++i) {
    const double s = (i + 0.5) / steps, delta = answer.approach * (1 - s * s);
    const double speed =
        std::sqrt(2 * (energy - interpolate(approach, 1, work, 0.4, delta)) / impact.mass());
    const double end = (i + 1.0) / steps;
    t.push_back(t.back() + 2 * answer.approach * s / (speed * steps));
    F.push_back(interpolate(approach, 1, force, 2.0 / 3, answer.approach * (1 - end * end)));
  }
  for (std::size_t i = t.size(); i-- > 1;) {
    answer.time.push_back(t.back() - t[i]);
    answer.history.push_back(F[i]);
  }
  for (std::size_t i = 0; i < t.size(); ++i) {
    answer.time.push_back(t.back() + t[i]);
    answer.history.push_back(F[i]);
  }
  answer.duration = 2 * t.back();
  return answer;
}

}  // namespace cbr::test
