// SPDX-License-Identifier: GPL-3.0-or-later
// Fallback of Newton's method: singular W, gaps that no impulse satisfies, strong friction.
#pragma once

#include "dynamics/contact/laws/contact_laws.hpp"

namespace cbr {

// Factors W = L L^T, with rank(W) columns; y = L^T p is the motion by the impulses, and gap = g + L
// y. With P the projection onto the cones (project()), the laws hold if
//   p = P(p - sigma (g + L y)),  y = L^T p     for any sigma > 0
// (Alart, Curnier 1991, doi 10.1016/0045-7825(91)90022-X). The augmented Lagrangian iterates with
// the previous p on the right:
//   p_k+1 = P(p_k - sigma (g + L y)),  R(y) = y - L^T P(p_k - sigma (g + L y)) = 0
// Semismooth Newton solves R = 0 in the r unknowns y, (I + sigma L^T P' L) dy = -R. That matrix is
// regular for every W. Without friction R is the gradient of a strongly convex function,
//   Phi(y) = 1/2 |y|^2 + 1/(2 sigma) |P(p_k - sigma (g + L y))|^2,
// which decreases along every dy. So each problem has one solution, to which Newton's method
// converges from any start. The p_k are those of the proximal point method (Rockafellar 1976, doi
// 10.1137/0314056) and tend to a solution if one exists. Otherwise the gaps tend to those of least
// violation (Chiche, Gilbert 2016), and p grows. With friction |R| decreases, a solution need not
// exist, and the violation measures the result. W is dense, or copied. One step costs n r^2 flops,
// n rows of points with an impulse.
class AugmentedLagrangian {
 public:
  // Scales each point to w = 1. ok() is false if W has too many rows or too high a rank.
  explicit AugmentedLagrangian(const ContactProblem& problem);
  bool ok() const { return L_.cols() > 0; }

  struct Result {
    Vector p;              // within the cones, the best of all p_k
    Vector motion;         // final gaps g + L y of the last y, if p grows without bound
    double violation = 0;  // of p, a length
    int steps = 0;         // Newton steps
  };
  // Starts at p, ends when no law is violated by more than `tolerance`, a length.
  Result solve(const ContactProblem& problem, const Vector& g, const Vector& p,
               double tolerance) const;

 private:
  Matrix L_;      // rows of the problem x r
  Vector scale_;  // per row: 1 / sqrt(w), 0 for rows of zeros
};

}  // namespace cbr
