// SPDX-License-Identifier: GPL-3.0-or-later
// Impulses on a singular W from the coordinates that it feels.
#pragma once

#include "dynamics/contact/solve/cone/cone_problem.hpp"

namespace cbr {

struct AugmentedLagrangian {
  Points p;              // scaled
  double violation = 0;  // as cbr::violation
  int steps = 0;         // Newton's, all together
};

// p_next = P(p - sigma (g + L y)) with y = L^T p_next (Alart, Curnier 1991,
// doi 10.1016/0045-7825(91)90022-X): y - L^T P(p - sigma (g + L y)) = 0 by semismooth Newton with
// line search in the r unknowns y. sigma grows from `sigma` as long as that goes well. One step
// costs 3 n r^2 flops, n of points with an impulse.
AugmentedLagrangian augmented_lagrangian(const ConeProblem& cones, const ConeGaps& gaps, Points p,
                                         double sigma, int most_steps, double tolerance);

}  // namespace cbr
