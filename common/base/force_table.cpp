// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/force_table.hpp"

#include <algorithm>

namespace cbr {

std::size_t ForceTable::segment(double x) const {
  const auto inner = std::upper_bound(at.begin() + 1, at.end() - 1, x);
  return static_cast<std::size_t>(inner - at.begin()) - 1;
}

double ForceTable::slope_of(std::size_t i) const {
  return (force[i + 1] - force[i]) / (at[i + 1] - at[i]);
}

double ForceTable::value(double x) const {
  const std::size_t i = segment(x);
  return force[i] + slope_of(i) * (x - at[i]);
}

double ForceTable::slope(double x) const { return slope_of(segment(x)); }

// By segments, so that no difference of large integrals remains.
double ForceTable::mean(double from, double to) const {
  if (from > to) return mean(to, from);
  const std::size_t first = segment(from), last = segment(to);
  if (first == last) return 0.5 * (value(from) + value(to));
  double sum = 0, a = from, f = value(from);
  for (std::size_t i = first + 1; i <= last; ++i) {
    sum += 0.5 * (f + force[i]) * (at[i] - a);
    a = at[i];
    f = force[i];
  }
  return (sum + 0.5 * (f + value(to)) * (to - a)) / (to - from);
}

double ForceTable::mean_slope(double from, double to) const {
  if (segment(from) == segment(to)) return 0.5 * slope(to);
  // Round-off of a short range across a corner would be any slope
  return std::clamp((value(to) - mean(from, to)) / (to - from), 0.0, 0.5 * steepest());
}

double ForceTable::steepest() const {
  double most = 0;
  for (std::size_t i = 0; i + 1 < at.size(); ++i) most = std::max(most, slope_of(i));
  return most;
}

}  // namespace cbr
