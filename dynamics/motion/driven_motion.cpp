// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/prescribed_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cbr {
namespace {

// Of the shorter interval beside it, what a corner of the velocity is rounded over.
constexpr double rounded_share = 1e-6;

// Accelerations that are linear from `start` to `end` in each interval between the times, and 0
// outside. Jumps take `rounded_share` of the shorter interval beside them.
History rounded(const std::vector<double>& t, const std::vector<double>& start,
                const std::vector<double>& end) {
  const std::size_t n = t.size();
  History a;
  const auto add = [&](double time, double value) {
    a.time.push_back(time);
    a.value.push_back(value);
  };
  for (std::size_t i = 0; i < n && n > 1; ++i) {
    const double left = i > 0 ? t[i] - t[i - 1] : HUGE_VAL,
                 right = i + 1 < n ? t[i + 1] - t[i] : HUGE_VAL,
                 half = 0.5 * rounded_share * std::min(left, right);
    const double before = i > 0 ? end[i - 1] : 0, after = i + 1 < n ? start[i] : 0;
    const auto inside = [&](double near, double far, double length) {
      return near + half / length * (far - near);
    };
    if (t[i] < half || before == after) {  // the run begins there, or nothing jumps
      add(t[i], after);
    } else {
      add(t[i] - half, i > 0 ? inside(before, start[i - 1], left) : 0);
      add(t[i] + half, i + 1 < n ? inside(after, end[i], right) : 0);
    }
  }
  return a;
}

// Of a piecewise linear velocity.
History velocity_accelerations(double value, const History& velocity) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i + 1 < velocity.time.size(); ++i)
    slopes.push_back(value * (velocity.value[i + 1] - velocity.value[i]) /
                     (velocity.time[i + 1] - velocity.time[i]));
  return rounded(velocity.time, slopes, slopes);
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

// Of the cubic spline, with smaller slopes where it would leave the values of its table: a ramp
// that ends in a constant does not overshoot (Hyman 1983, doi 10.1137/0904045).
History displacement_accelerations(double value, const History& displacement, double speed,
                                   double end) {
  const std::vector<double>& t = displacement.time;
  const std::size_t n = t.size();
  if (n < 2) return {{0}, {0}};
  std::vector<double> y;
  for (const double factor : displacement.value) y.push_back(value * factor);
  const Vector a = spline_curvatures(t, y, speed, t.back() >= end);
  std::vector<double> secant, begins, ends, slope{speed};
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = t[i + 1] - t[i];
    secant.push_back((y[i + 1] - y[i]) / h);
    begins.push_back(a[i]);
    ends.push_back(a[i + 1]);
    slope.push_back(secant[i] + h / 6 * (a[i] + 2 * a[i + 1]));
  }
  for (std::size_t i = 1; i < n; ++i) {
    const double before = secant[i - 1], after = i + 1 < n ? secant[i] : before,
                 most = 3 * std::min(std::abs(before), std::abs(after));
    const bool rises = before > 0 && after > 0, falls = before < 0 && after < 0;
    const double limited = std::clamp(slope[i], rises ? 0 : -most, falls ? 0 : most);
    if (limited == slope[i]) continue;
    slope[i] = limited;
    for (std::size_t k = i - 1; k < std::min(i + 1, n - 1); ++k) {
      const double h = t[k + 1] - t[k];
      begins[k] = (6 * secant[k] - 4 * slope[k] - 2 * slope[k + 1]) / h;
      ends[k] = (2 * slope[k] + 4 * slope[k + 1] - 6 * secant[k]) / h;
    }
  }
  return rounded(t, begins, ends);
}

}  // namespace

DrivenAxis::DrivenAxis(SupportMotion motion, double value, const History& history, double speed,
                       const TimeOptions& time) {
  if (motion == SupportMotion::displacement && time.is_static) {
    follow(value, history);
  } else if (motion == SupportMotion::displacement) {
    const double first = !history.time.empty() && history.time.front() > 0 ? 0 : speed;
    integrate(displacement_accelerations(value, history, first, time.end), first, time.end);
  } else if (motion == SupportMotion::velocity) {
    const History a = velocity_accelerations(value, history);
    integrate(a.time.empty() ? History{{0}, {0}} : a, value * LoadHistory(history).value(0),
              time.end);
  } else {
    History a = history;
    if (a.time.empty()) a = {{0}, {1}};
    for (double& factor : a.value) factor *= value;
    integrate(a, speed, time.end);
  }
}

void DrivenAxis::follow(double value, const History& displacement) {
  is_static_ = true;
  acceleration_ = LoadHistory(History{{0}, {0}});
  knots_.push_back({0, 0, 0, 0, 0, 0});
  // The first load step begins at the initial positions, whatever the table begins with
  constexpr double at_once = std::numeric_limits<double>::min();
  const std::size_t n = displacement.time.size();
  if (n > 0 && displacement.time.front() > 0)
    knots_.push_back({at_once, 0, 0, 0, value * displacement.value.front(), 0});
  for (std::size_t i = 0; i < n; ++i) {
    const double t = std::max(displacement.time[i], at_once), integral = displacement_integral(t),
                 s = value * displacement.value[i];
    const double v = i + 1 < n ? value * (displacement.value[i + 1] - displacement.value[i]) /
                                     (displacement.time[i + 1] - t)
                               : 0;
    knots_.push_back({t, 0, 0, v, s, integral});
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
  if (is_static_) return 0;
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
