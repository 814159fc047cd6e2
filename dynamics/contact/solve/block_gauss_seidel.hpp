// SPDX-License-Identifier: GPL-3.0-or-later
// Block Gauss-Seidel: each point in turn by its own law, exactly. Robust, with linear convergence.
#pragma once

#include <vector>

#include "dynamics/contact/laws/contact_laws.hpp"
#include "dynamics/contact/laws/coulomb_point.hpp"

namespace cbr {

// Holds the points' blocks of W.
class BlockGaussSeidel {
 public:
  explicit BlockGaussSeidel(const ContactProblem& problem);
  // Up to max_sweeps over all points, forward and backward in turn; ends if no gap changes by more
  // than `tolerance` (a length). Updates p (m) and gap = g + W p. Returns the number of sweeps.
  int sweep(const ContactProblem& problem, int max_sweeps, double tolerance, Vector& p,
            Vector& gap) const;

 private:
  double relax(const ContactProblem& problem, Index point, Vector& p, Vector& gap) const;
  std::vector<Matrix3> blocks_;
  std::vector<Matrix3> inverses_;  // for tied points
  std::vector<CoulombPoint> coulomb_;
};

}  // namespace cbr
