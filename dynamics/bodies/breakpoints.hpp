// SPDX-License-Identifier: GPL-3.0-or-later
// Times at which load histories bend.
#pragma once

#include <algorithm>
#include <vector>

#include "common/scene.hpp"

namespace cbr {

class Breakpoints {
 public:
  void add(const History& history) {
    times_.insert(times_.end(), history.time.begin(), history.time.end());
    std::sort(times_.begin(), times_.end());
    // Loads often share a history
    times_.erase(std::unique(times_.begin(), times_.end()), times_.end());
  }

  // piece(from, to, whole) for the parts of [t, t + h] in which all histories are linear, in order; `whole`: there is only one.
  // Breakpoints that differ by round-off are one: no part is shorter than 1e-9 h.
  template <class Piece>
  void cut(double t, double h, const Piece& piece) const {
    const double end = t + h, tolerance = 1e-9 * h;
    double from = t;
    for (auto next = std::upper_bound(times_.begin(), times_.end(), t + tolerance);; ++next) {
      while (next != times_.end() && *next <= from + tolerance) ++next;
      if (next == times_.end() || *next >= end - tolerance) return piece(from, end, from == t);
      piece(from, *next, false);
      from = *next;
    }
  }

 private:
  std::vector<double> times_;  // ascending
};

}  // namespace cbr
