// SPDX-License-Identifier: GPL-3.0-or-later
// Linear system of one Newton step, for a fixed set of closed, sticking and sliding points: by its
// own factor or Krylov methods, or by the inverse of all W.
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
  // residual by the factor `reduction`. `products` with W are counted.
  Vector solve(const Vector& g, const Vector& start, double reduction,
               Index* products = nullptr) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Z = W^-1 (m x m). With gaps E y of the r released rows, the impulses are p + Z (E y - gap). A
// sliding point releases two rows, an open one all. Their laws give y from an r x r system, so a
// step takes r^3 / 3 + 2 m^2 multiplications.
class FullInverse {
 public:
  explicit FullInverse(const ContactProblem& problem);
  bool ok() const { return Z_.size() > 0; }  // false: W is singular to round-off
  // Whether the set releases at most half of the rows: the system of more costs as much as the 20
  // products of Krylov methods.
  static bool serves(const ContactProblem& problem, const ContactSet& set);
  // Impulses (m) of a set, from p (m) with gap = g + W p.
  Vector solve(const ContactProblem& problem, const ContactSet& set, const Vector& p,
               const Vector& gap) const;

 private:
  Matrix Z_;
};

}  // namespace cbr
