// SPDX-License-Identifier: GPL-3.0-or-later
// The last digits of impulses on a singular W.
#pragma once

#include "dynamics/contact/cone_problem.hpp"

namespace cbr {

struct ProximalNewton {
  Points p;              // scaled, before projection
  double violation = 0;  // as cbr::violation
  int steps = 0;         // Newton's, all together
};

// The proximal point method (Rockafellar 1976, doi 10.1137/0314056) from p: gap + epsilon (p_next - p) in the place of the gap,
// which is regular and changes p least; each by semismooth Newton with line search on the natural map of all laws. epsilon falls as
// long as that goes well. One step costs 3 n r^2 flops.
ProximalNewton proximal_newton(const ConeProblem& cones, const ConeGaps& gaps, Points p, double epsilon, int most_steps,
                               double tolerance);

}  // namespace cbr
