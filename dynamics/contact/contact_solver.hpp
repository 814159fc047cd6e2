// SPDX-License-Identifier: GPL-3.0-or-later
// The impulses of one step: gap = g + W p with W symmetric positive semi-definite, and a law at every point.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contact/contact_point.hpp"
#include "dynamics/contact/response.hpp"

namespace cbr {

struct ContactSolution {
  Vector p;    // impulses; least-norm among those that can be told apart by no gap (W singular)
  Vector gap;  // g + W p
  // Largest violation of the laws, as a share of the largest |g|: of gaps that must not be negative or must be closed; of Coulomb's
  // law as a length (natural map with the diagonal of W). Not small when no p can satisfy all: p is then a best one, never a NaN.
  double residual = 0;
  int iterations = 0;
  bool fallback = false;  // the exact active-set method did not end; see the .cpp for what comes then
};

// Holds W and what it has factored, for as long as W stands.
class ContactSolver {
 public:
  ContactSolver(GapResponse W, std::vector<PointLaw> laws);
  ~ContactSolver();
  ContactSolver(ContactSolver&&) noexcept;
  ContactSolver& operator=(ContactSolver&&) noexcept;

  const GapResponse& W() const;
  // `guess`: impulses of the last step (same rows), or empty: where to start from.
  ContactSolution solve(const Vector& g, const Vector& guess);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
