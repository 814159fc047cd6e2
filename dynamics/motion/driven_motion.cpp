// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/driven_motion.hpp"

#include <algorithm>
#include <cmath>

namespace cbr {
namespace {

// Of the shorter interval beside it, what a corner of the velocity is rounded over.
constexpr double rounded_share = 1e-6;

// The slope of a piecewise linear velocity, which changes within `rounded_share` of an interval at
// each of its points.
History slopes(double value, const History& velocity) {
  const std::size_t n = velocity.time.size();
  History a;
  double before = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double left = i > 0 ? velocity.time[i] - velocity.time[i - 1] : HUGE_VAL;
    const double right = i + 1 < n ? velocity.time[i + 1] - velocity.time[i] : HUGE_VAL;
    const double after =
        i + 1 < n ? value * (velocity.value[i + 1] - velocity.value[i]) / right : 0;
    const double half =
        std::isfinite(std::min(left, right)) ? 0.5 * rounded_share * std::min(left, right) : 0;
    if (half > 0 && velocity.time[i] < half) {  // the run begins there
      a.time.push_back(velocity.time[i]);
      a.value.push_back(after);
    } else if (half > 0) {
      a.time.insert(a.time.end(), {velocity.time[i] - half, velocity.time[i] + half});
      a.value.insert(a.value.end(), {before, after});
    }
    before = after;
  }
  return a;
}

// Second derivatives of the cubic spline through the points, with its first derivative given at the
// start, and at the end or, with `ends_free`, no curvature there: Thomas's elimination of the
// tridiagonal system (de Boor, A Practical Guide to Splines, ch. IV).
Vector spline_curvatures(const std::vector<double>& t, const std::vector<double>& y,
                         double start_slope, bool ends_free) {
  const auto n = static_cast<Index>(t.size());
  Vector diagonal(n), upper = Vector::Zero(n), right(n);
  const auto secant = [&](Index i) { return (y[i + 1] - y[i]) / (t[i + 1] - t[i]); };
  for (Index i = 0; i < n; ++i) {
    const double before = i > 0 ? t[i] - t[i - 1] : 0, after = i + 1 < n ? t[i + 1] - t[i] : 0;
    diagonal[i] = (before + after) / 3;
    upper[i] = after / 6;
    right[i] = (i + 1 < n ? secant(i) : 0) - (i > 0 ? secant(i - 1) : start_slope);
  }
  if (ends_free) {
    diagonal[n - 1] = 1;
    right[n - 1] = 0;
  }
  for (Index i = 1; i < n; ++i) {
    const double lower = i == n - 1 && ends_free ? 0 : upper[i - 1];
    const double factor = lower / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    right[i] -= factor * right[i - 1];
  }
  Vector curvature(n);
  for (Index i = n - 1; i >= 0; --i)
    curvature[i] = (right[i] - (i + 1 < n ? upper[i] * curvature[i + 1] : 0)) / diagonal[i];
  return curvature;
}

History spline_accelerations(double value, const History& displacement, double speed, double end) {
  if (displacement.time.size() < 2) return {{0}, {0}};
  std::vector<double> y;
  for (const double factor : displacement.value) y.push_back(value * factor);
  const std::vector<double>& t = displacement.time;
  const Vector a = spline_curvatures(t, y, speed, t.back() >= end);
  // At rest before the first point and after the last one: jumps of the acceleration there are as
  // steep as at corners of velocities.
  History history{t, {a.data(), a.data() + a.size()}};
  const auto n = static_cast<Index>(t.size());
  const double last = 0.5 * rounded_share, inner = 1 - last;
  history.time.back() = last * t[n - 2] + inner * t[n - 1];
  history.value.back() = last * a[n - 2] + inner * a[n - 1];
  history.time.push_back(t[n - 1] + last * (t[n - 1] - t[n - 2]));
  history.value.push_back(0);
  if (t[0] > 0) {
    history.time.front() = inner * t[0] + last * t[1];
    history.value.front() = inner * a[0] + last * a[1];
    history.time.insert(history.time.begin(), t[0] - last * (t[1] - t[0]));
    history.value.insert(history.value.begin(), 0);
  }
  return history;
}

}  // namespace

DrivenAxis::DrivenAxis(SupportMotion motion, double value, const History& history, double speed,
                       double end) {
  if (motion == SupportMotion::displacement) {
    const double first = !history.time.empty() && history.time.front() > 0 ? 0 : speed;
    integrate(spline_accelerations(value, history, first, end), first, end);
  } else if (motion == SupportMotion::velocity) {
    const History a = slopes(value, history);
    integrate(a.time.empty() ? History{{0}, {0}} : a, value * LoadHistory(history).value(0), end);
  } else {
    History a = history;
    if (a.time.empty()) a = {{0}, {1}};
    for (double& factor : a.value) factor *= value;
    integrate(a, speed, end);
  }
}

void DrivenAxis::integrate(const History& acceleration, double speed, double end) {
  acceleration_ = LoadHistory(acceleration);
  std::vector<double> times{0};
  for (const double t : acceleration.time)
    if (t > 0) times.push_back(t);
  double v = speed, s = 0, integral = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const bool is_last = i + 1 == times.size();
    const double h = is_last ? std::max(0.0, end - times[i]) : times[i + 1] - times[i];
    const double a = acceleration_.value(times[i]),
                 next = is_last ? a : acceleration_.value(times[i + 1]);
    const double slope = is_last ? 0 : (next - a) / h;
    knots_.push_back({times[i], a, slope, v, s, integral});
    if (times[i] <= end) {
      largest_speed_ = std::max(largest_speed_, std::abs(v));
      const double turn = slope != 0 ? -a / slope : -1;  // where the acceleration changes its sign
      if (turn > 0 && turn < h)
        largest_speed_ = std::max(largest_speed_, std::abs(v + 0.5 * a * turn));
    }
    integral += h * (s + h * (v / 2 + h * (a / 6 + h * slope / 24)));
    s += h * (v + h * (a / 2 + h * slope / 6));
    v += h * (a + 0.5 * h * slope);
  }
  largest_speed_ = std::max(largest_speed_, std::abs(v));
}

const DrivenAxis::Knot& DrivenAxis::knot_at(double t) const {
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), t,
                                      [](double time, const Knot& knot) { return time < knot.t; });
  return after == knots_.begin() ? knots_.front() : *std::prev(after);
}

double DrivenAxis::displacement(double t) const {
  const Knot& knot = knot_at(t);
  const double h = t - knot.t;
  return knot.s + h * (knot.v + h * (knot.a / 2 + h * knot.slope / 6));
}

double DrivenAxis::velocity(double t) const {
  const Knot& knot = knot_at(t);
  const double h = t - knot.t;
  return knot.v + h * (knot.a + 0.5 * h * knot.slope);
}

double DrivenAxis::displacement_integral(double t) const {
  const Knot& knot = knot_at(t);
  const double h = t - knot.t;
  return knot.integral + h * (knot.s + h * (knot.v / 2 + h * (knot.a / 6 + h * knot.slope / 24)));
}

bool DrivenMotion::empty() const {
  return std::all_of(axes.begin(), axes.end(), [](const auto& axis) { return axis.empty(); });
}

Vector3 DrivenMotion::displacement(double t) const {
  Vector3 s = Vector3::Zero();
  for (int c = 0; c < 3; ++c)
    if (!axes[c].empty()) s[c] = axes[c].front().displacement(t);
  return s;
}

Vector3 DrivenMotion::velocity(double t) const {
  Vector3 v = Vector3::Zero();
  for (int c = 0; c < 3; ++c)
    if (!axes[c].empty()) v[c] = axes[c].front().velocity(t);
  return v;
}

Vector3 DrivenMotion::largest_speed() const {
  Vector3 v = Vector3::Zero();
  for (int c = 0; c < 3; ++c)
    if (!axes[c].empty()) v[c] = axes[c].front().largest_speed();
  return v;
}

}  // namespace cbr
