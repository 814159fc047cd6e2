// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/solve: the impulses of one step.
//
// The impulses of one step: gap = g + W p with W symmetric positive semi-definite, and a law at
// every point.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contact/laws/contact_laws.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"

namespace cbr {

class StateArchive;

struct ContactSolution {
  // Impulses within the laws' cones. Where W cannot tell several apart (redundant points): the
  // least, each row weighed by the root of its W_ii; with many rows (Krylov methods) the one
  // nearest the guess.
  Vector p;
  Vector gap;  // g + W p, by W or by what answers for it
  // Largest violation of a law by the natural map, w |p - P(p - gap / w)|, as a share of the
  // largest |g|: of gaps that must not be negative or must be closed, of Coulomb's law as a length
  // (w: largest diagonal entry of W among the point's rows). Not small when no p satisfies all:
  // without friction p is then one of bounded size whose gaps violate least, never a NaN. Infinite,
  // and p = 0, for a g or W that is not finite, and where magnitudes leave a double's reach on the
  // way.
  double residual = 0;
  int iterations = 0;     // Newton's and sweeps, added up
  bool fallback = false;  // Newton's first attempt failed; see the .cpp for what comes then
};

// `first_methods`: ends where ContactSolution::fallback says that they failed, as for a W that may
// be formed anew instead.
enum class Effort : char { all, first_methods };

// Holds W and what it has factored, for as long as W stands.
class ContactSolver {
 public:
  // stands: W serves more than a few solutions.
  ContactSolver(GapResponse W, std::vector<PointLaw> laws, bool stands = true);
  ~ContactSolver();
  ContactSolver(ContactSolver&&) noexcept;
  ContactSolver& operator=(ContactSolver&&) noexcept;

  const GapResponse& W() const;
  // `guess`: impulses of the last step (same rows), or empty: where to start from. `gaps_of`: for
  // callers who want the effect of the solution in any case; empty: by W.
  ContactSolution solve(const Vector& g, const Vector& guess, Effort effort = Effort::all,
                        const GapsOf& gaps_of = {});
  // The impulses that the factor of the last solution's closed rows gives, when it has one and the
  // laws' cones hold them: for callers who know what they do to the gaps without W.
  bool standing_impulses(const Vector& g, Vector& p);
  // Largest violation of a law, a length (see ContactSolution::residual); `gap` need not be that of
  // W and p.
  double largest_violation(const Vector& p, const Vector& gap) const;
  // Other points: i was point from[i] before, with the same law and entries of W, or is new (-1).
  // What was factored is adapted.
  void renumber(GapResponse W, std::vector<PointLaw> laws, const std::vector<Index>& from);
  void keep_state(StateArchive& archive);
  // Another W of the same bodies begins with the methods that a singular one needed before.
  void begin_as(const ContactSolver& other);
  bool W_is_singular() const;  // as far as a solution has needed to know
  // dense symmetric factors so far that were not adapted from the one before
  Index n_factored() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
