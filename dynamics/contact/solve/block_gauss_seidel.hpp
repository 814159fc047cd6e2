// SPDX-License-Identifier: GPL-3.0-or-later
// Point by point, each by its own law exactly: robust, and linear in its convergence.
#pragma once

#include <vector>

#include "dynamics/contact/laws/contact_laws.hpp"
#include "dynamics/contact/laws/coulomb_point.hpp"

namespace cbr {

// The points' blocks of W, prepared once.
class BlockGaussSeidel {
 public:
  explicit BlockGaussSeidel(const ContactProblem& problem);
  // Up to max_sweeps over all points, forward and backward in turn; stops when no point's gap was
  // moved by more than `tolerance` (a length). p (m) and gap = g + W p are updated. Returns the
  // number of sweeps.
  int sweep(const ContactProblem& problem, int max_sweeps, double tolerance, Vector& p,
            Vector& gap) const;

 private:
  double relax(const ContactProblem& problem, Index point, Vector& p, Vector& gap) const;
  std::vector<Matrix3> blocks_;
  std::vector<Matrix3> inverses_;  // of tied points
  std::vector<CoulombPoint> coulomb_;
};

}  // namespace cbr
