// SPDX-License-Identifier: GPL-3.0-or-later
// Coulomb's law by an interior point method: no active set, so that neither singular W nor points
// without rank make it cycle.
#pragma once

#include "dynamics/contact/solve/cone/cone_problem.hpp"

namespace cbr {

// x = (mu p_n, p_t) and z = (gap_n / mu + |gap_t|, gap_t) are to lie in the second-order cone with
// x o z = 0 (de Saxce's form; Acary, Cadoux, Lemarechal, Malick 2011, doi 10.1002/zamm.201000073).
// A primal-dual method (Nesterov and Todd's scaling, Mehrotra's predictor) follows x o z = tau to
// tau -> 0. In between impulses are in the middle of what W cannot tell apart, so symmetric
// problems have symmetric ones. The slip's length, which makes Coulomb's law no minimum of
// anything, is differentiated where it is large beside what complementarity is left. One step costs
// 3 n r^2 flops. Tied points: equations. Friction coefficients below 1e-6 are taken as that.
struct InteriorPoint {
  Points p;              // of all iterates the one that violates least (scaled, before projection)
  double violation = 0;  // as cbr::violation
  int steps = 0;
};
InteriorPoint interior_point(const ConeProblem& cones, const ConeGaps& gaps, double tolerance);

}  // namespace cbr
