// SPDX-License-Identifier: GPL-3.0-or-later
// What answers where Newton's method does not: W singular, gaps that no impulse satisfies, strong
// friction.
#pragma once

#include "dynamics/contact/laws/contact_laws.hpp"

namespace cbr {

// W = L L^T, with as many columns as W has rank; y = L^T p is the motion that the impulses cause,
// and gap = g + L y. With P the projection onto the cones (project()), the laws hold when
//   p = P(p - sigma (g + L y)),  y = L^T p     for any sigma > 0
// (Alart, Curnier 1991, doi 10.1016/0045-7825(91)90022-X). The augmented Lagrangian takes p on the
// right from before:
//   p_k+1 = P(p_k - sigma (g + L y)),  R(y) = y - L^T P(p_k - sigma (g + L y)) = 0
// R = 0 is solved in the r unknowns y by semismooth Newton, (I + sigma L^T P' L) dy = -R. That
// matrix is regular whatever W is. Without friction R is the gradient of a strongly convex
// function,
//   Phi(y) = 1/2 |y|^2 + 1/(2 sigma) |P(p_k - sigma (g + L y))|^2,
// which falls along every dy: each problem has one solution, and Newton's method ends there from
// any start. The p_k are those of the proximal point method (Rockafellar 1976,
// doi 10.1137/0314056): they tend to a solution where there is one; else the gaps tend to those
// that violate least (Chiche, Gilbert 2016), and p grows. With friction |R| is what falls, a
// solution need not exist, and the violation says what came of it. W is dense, or copied. One step
// costs n r^2 flops, n rows of points with an impulse.
class AugmentedLagrangian {
 public:
  // Scales each point to w = 1. ok() is false where W has too many rows or too high a rank.
  explicit AugmentedLagrangian(const ContactProblem& problem);
  bool ok() const { return L_.cols() > 0; }

  struct Result {
    Vector p;       // within the cones, the best of all p_k
    Vector motion;  // gaps that it ended with, where p grows without end: g + L y of the last y
    double violation = 0;  // of p, a length
    int steps = 0;         // Newton's
  };
  // From p, until no law is violated by more than `tolerance`, a length.
  Result solve(const ContactProblem& problem, const Vector& g, const Vector& p,
               double tolerance) const;

 private:
  Matrix L_;      // rows of the problem x r
  Vector scale_;  // of each row: 1 / sqrt(w), 0 where nothing moves
};

}  // namespace cbr
