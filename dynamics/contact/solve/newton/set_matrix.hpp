// SPDX-License-Identifier: GPL-3.0-or-later
// The linear system of one Newton step: what is closed, sticks and slides is fixed.
#pragma once

#include <memory>

#include "dynamics/contact/laws/contact_set.hpp"

namespace cbr {

enum class LinearSolver : char { factor, krylov };

// K = R^T W C + diag(alpha)   (n x n), p = C x; symmetric when nothing slides. Cholesky or LU,
// sparse or dense as W is; krylov: conjugate gradients or GMRES. A singular K is shifted by 1e-8 of
// its diagonal, and the shift taken back by refinement.
class SetMatrix {
 public:
  SetMatrix(const ContactProblem& problem, const ContactSet& set, LinearSolver solver);
  ~SetMatrix();
  SetMatrix(SetMatrix&&) noexcept;
  SetMatrix& operator=(SetMatrix&&) noexcept;
  // p (m) with R^T (g + W C x) + alpha x = 0. krylov: from `start` (m), its residual reduced by the
  // factor `reduction`.
  Vector solve(const Vector& g, const Vector& start, double reduction) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
