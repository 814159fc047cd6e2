// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/solve: impulses of one step.
//
// Solves gap = g + W p with W symmetric positive semi-definite, and a law at every point.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contact/laws/contact_laws.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"

namespace cbr {

class StateArchive;

struct ContactSolution {
  // Impulses within the laws' cones. If W is singular (redundant points): the smallest, weighted by
  // the roots of W_ii. With many rows (Krylov methods) the nearest to the guess.
  Vector p;
  Vector gap;  // g + W p
  // Largest violation of a law relative to the largest |g|, by the natural map, w |p - P(p - gap /
  // w)|. w: largest diagonal entry of W among the point's rows. It covers negative and unclosed
  // gaps, and Coulomb's law as a length. Not small if no p satisfies all. Without friction p is
  // then bounded, with gaps of least violation, never NaN. Infinite, and p = 0, for a g or W that
  // is not finite, and on overflow.
  double residual = 0;
  int iterations = 0;     // Newton iterations and sweeps
  bool fallback = false;  // the first Newton attempt failed; next methods: see contact_solver.cpp
};

// Holds W and its factors while W is valid.
class ContactSolver {
 public:
  ContactSolver(GapResponse W, std::vector<PointLaw> laws);
  ~ContactSolver();
  ContactSolver(ContactSolver&&) noexcept;
  ContactSolver& operator=(ContactSolver&&) noexcept;

  const GapResponse& W() const;
  // `guess`: impulses of the last step (same rows) to start from, or empty.
  ContactSolution solve(const Vector& g, const Vector& guess);
  // Impulses from the factor of the last closed rows, if there is one and they are within the laws'
  // cones. For callers with another way to compute gaps.
  bool standing_impulses(const Vector& g, Vector& p);
  // Largest violation of a law, a length (see ContactSolution::residual); `gap` may be another than
  // W gives.
  double largest_violation(const Vector& p, const Vector& gap) const;
  // The same laws with other coefficients of friction: what was factored stands.
  void take_friction(const std::vector<PointLaw>& laws);
  void keep_state(StateArchive& archive);
  // Starts with the methods that a singular W of the same bodies needed before.
  void begin_as(const ContactSolver& other);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
