// SPDX-License-Identifier: GPL-3.0-or-later
// Linear system of one Newton step, for a fixed set of closed, sticking and sliding points.
#pragma once

#include <memory>

#include "dynamics/contact/laws/contact_set.hpp"

namespace cbr {

enum class LinearSolver : char { factor, krylov };

// K = R^T W C + diag(alpha)   (n x n), p = C x; symmetric if nothing slides. Cholesky or LU, sparse
// or dense as W; krylov: conjugate gradients or GMRES. A singular K is shifted by 1e-8 of its
// diagonal, and refined.
class SetMatrix {
 public:
  SetMatrix(const ContactProblem& problem, const ContactSet& set, LinearSolver solver);
  ~SetMatrix();
  SetMatrix(SetMatrix&&) noexcept;
  SetMatrix& operator=(SetMatrix&&) noexcept;
  // Factored without a shift.
  bool has_factor() const;
  // p (m) with R^T (g + W C x) + alpha x = 0. krylov: starts at `start` (m) and reduces its
  // residual by the factor `reduction`.
  Vector solve(const Vector& g, const Vector& start, double reduction) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
