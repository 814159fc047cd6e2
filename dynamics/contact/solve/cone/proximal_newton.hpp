// SPDX-License-Identifier: GPL-3.0-or-later
// The last digits of impulses on a singular W.
#pragma once

#include "dynamics/contact/solve/cone/cone_problem.hpp"

namespace cbr {

struct ProximalNewton {
  Points p;              // scaled, before projection
  double violation = 0;  // as cbr::violation
  int steps = 0;         // Newton's, all together
};

enum class NewtonStart : char {
  near,
  uncertain  // ends soon when three steps have not brought the violation down tenfold
};

// The proximal point method (Rockafellar 1976, doi 10.1137/0314056) from p: gap + epsilon (p_next -
// p) in the place of the gap, which is regular and changes p least; each by semismooth Newton with
// line search on the natural map of all laws. epsilon falls as long as that goes well. Ends also
// when two such problems have not halved the violation. One step costs 3 n r^2 flops, n of points
// with an impulse.
ProximalNewton proximal_newton(const ConeProblem& cones, const ConeGaps& gaps, Points p,
                               double epsilon, int most_steps, double tolerance, NewtonStart start);

}  // namespace cbr
