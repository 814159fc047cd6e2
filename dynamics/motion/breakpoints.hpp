// SPDX-License-Identifier: GPL-3.0-or-later
// Times at which load histories bend.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/motion/load_history.hpp"

namespace cbr {

class Breakpoints {
 public:
  // Each history once: every cut asks all of them.
  void add(const LoadHistory& history) {
    if (history.has_points()) histories_.push_back(history);
  }

  // piece(from, to, whole) for the parts of [t, t + h] in which all histories are linear, in order;
  // `whole`: there is only one. Breakpoints that differ by round-off are one: no part is shorter
  // than 1e-9 h.
  template <class Piece>
  void cut(double t, double h, const Piece& piece) const {
    const double end = t + h, tolerance = 1e-9 * h;
    for (double from = t;;) {
      const double next = next_bend(from + tolerance);
      if (!(next < end - tolerance)) return piece(from, end, from == t);
      piece(from, next, false);
      from = next;
    }
  }

 private:
  double next_bend(double t) const {
    double next = HUGE_VAL;
    for (const LoadHistory& history : histories_) next = std::min(next, history.next_bend(t));
    return next;
  }

  std::vector<LoadHistory> histories_;
};

}  // namespace cbr
