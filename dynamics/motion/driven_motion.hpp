// SPDX-License-Identifier: GPL-3.0-or-later
// How the supports of an instance move: a translation given by its displacement, velocity or
// acceleration.
#pragma once

#include <array>
#include <vector>

#include "common/scene/scene.hpp"
#include "dynamics/motion/load_history.hpp"

namespace cbr {

// Along one axis. The acceleration is piecewise linear, so that a body takes it as it takes any
// load; velocity and displacement are its integrals in closed form.
class DrivenAxis {
 public:
  // value: what the history multiplies, in m, m/s or m/s^2.
  //  acceleration: begins with `speed`.
  //  velocity: piecewise linear; each corner is rounded over a millionth of the shorter interval
  //  beside it.
  //  displacement: value times the history. In statics it is linear between the points of its
  //  table, and constant before them. In motion, where the table begins with 0, it is their cubic
  //  spline, with smaller slopes where that would leave the values of the table, but beside a peak.
  //  It begins with `speed` where the table begins at 0, else at rest, and ends at rest where the
  //  table ends before the run.
  // Precondition: times from 0 on.
  DrivenAxis(SupportMotion motion, double value, const History& history, double speed,
             const TimeOptions& time);

  double displacement(double t) const;  // since t = 0
  double velocity(double t) const;
  double displacement_integral(double t) const;            // from 0 to t
  double largest_speed() const { return largest_speed_; }  // from 0 to the end
  const LoadHistory& acceleration() const { return acceleration_; }

 private:
  struct Knot {
    double t, a, slope, v, s, integral;  // from t on; integral of s up to t
  };
  void follow(double value, const History& displacement);
  void integrate(const History& acceleration, double speed, double end);
  const Knot& knot_at(double t) const;

  LoadHistory acceleration_;
  std::vector<Knot> knots_;
  double largest_speed_ = 0;
  bool is_static_ = false;  // velocities are none
};

// Along all axes: scene axes; an axis without motion is held where it is, or free.
struct DrivenMotion {
  std::array<std::vector<DrivenAxis>, 3> axes;  // none or one each

  bool empty() const;
  Vector3 displacement(double t) const;
  Vector3 velocity(double t) const;
  Vector3 largest_speed() const;
};

}  // namespace cbr
