// SPDX-License-Identifier: GPL-3.0-or-later
// A force over an elongation: nonlinear springs, gaps and stops.
#pragma once

#include <vector>

namespace cbr {

// Force over elongation, moment over angle, or pressure over depth: piecewise linear, continued by
// its first and its last slope. `at` ascends, and `force` never falls.
struct ForceTable {
  std::vector<double> at, force;

  bool empty() const { return at.empty(); }
  double value(double x) const;
  double slope(double x) const;                     // of the segment from x on
  double mean(double from, double to) const;        // integral over [from, to] / (to - from)
  double mean_slope(double from, double to) const;  // its derivative by `to`
  double energy(double x) const { return x * mean(0, x); }
  double steepest() const;
  bool operator==(const ForceTable&) const = default;

 private:
  std::size_t segment(double x) const;
  double slope_of(std::size_t segment) const;
};

}  // namespace cbr
