// SPDX-License-Identifier: GPL-3.0-or-later
// p >= 0, g + W p >= 0, p . (g + W p) = 0 with W symmetric positive semi-definite.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contact/response.hpp"

namespace cbr {

struct ComplementarityResult {
  Vector p;    // m, impulses >= 0; least-norm on the active set when W is singular there
  Vector gap;  // m, g + W p
  // Largest violation, as a share of the largest |g|: gaps below 0, and gaps of active constraints. Not small when no p can open
  // all gaps (more constraints than the bodies can satisfy): then p is the least-squares one. Never a NaN.
  double residual = 0;
  int iterations = 0;     // of the active set
  bool fallback = false;  // the active set cycled: projected Gauss-Seidel, then a descent active-set method
};

// Holds W and the factor of its active part while the active set stands.
class ComplementaritySolver {
 public:
  explicit ComplementaritySolver(GapResponse W);
  ~ComplementaritySolver();
  ComplementaritySolver(ComplementaritySolver&&) noexcept;
  ComplementaritySolver& operator=(ComplementaritySolver&&) noexcept;

  const GapResponse& W() const;
  // Primal-dual active set (Hintermueller, Ito, Kunisch 2002, doi 10.1137/S1052623401383558), started from `guess` (m) and the gaps
  // below 0.
  ComplementarityResult solve(const Vector& g, const std::vector<char>& guess);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
