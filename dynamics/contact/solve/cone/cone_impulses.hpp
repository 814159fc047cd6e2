// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/solve/cone: impulses of a singular W with friction.
//
// Impulses of all laws, with friction, where the response is singular: more points than the bodies
// have ways to give way.
#pragma once

#include "dynamics/contact/solve/cone/cone_problem.hpp"

namespace cbr {

struct ConeImpulses {
  Vector p, gap;        // within the laws' cones, as of ContactProblem
  double residual = 0;  // largest violation of a law, a length
  int steps = 0;
};

// From `guess` (impulses of the last step, or empty) when proximal Newton makes its way from there,
// else the interior point method, then proximal Newton for the last digits; where that does not
// reach `tolerance` (a length) an augmented Lagrangian from the best. The best of all. A solution
// exists when some motion opens every gap by more than mu times the slip that goes with it (Acary
// and others 2011, doi 10.1002/zamm.201000073), as one that drives the bodies apart does.
ConeImpulses cone_impulses(const ContactProblem& problem, const ConeProblem& cones, const Vector& g,
                           const Vector& guess, double tolerance);

}  // namespace cbr
