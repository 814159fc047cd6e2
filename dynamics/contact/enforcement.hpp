// SPDX-License-Identifier: GPL-3.0-or-later
// From constraints to impulses: the three enforcements. All conserve linear momentum exactly: what a slave node gets, its face
// gives.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/contact/complementarity.hpp"
#include "dynamics/contact/contact_surface.hpp"

namespace cbr {

// What one enforcement did in one step.
struct EnforcementResult {
  Vector p;             // per constraint, >= 0
  Vector gap;           // per constraint, at the end of the step
  double residual = 0;  // of complementarity, see ComplementarityResult
  bool fallback = false;
};

// Kept from step to step by a group of constraints that is solved together.
struct ImpulseMemory {
  std::vector<Constraint> rows;  // those that W was formed from
  double h = 0;
  std::optional<ComplementaritySolver> solver;
};

// `impulse`: 0 <= p, 0 <= g_end, p . g_end = 0 with g_end = g + W p the gap at the END of the step (Carpenter, Taylor, Katona 1991,
// doi 10.1002/nme.1620320107, with the bodies' full response). Adds to the bodies' impulses. W and its factor are kept while the
// rows of G stand.
EnforcementResult enforce_impulse(const std::vector<Constraint>& constraints, const std::vector<char>& guess, double h,
                                  std::vector<ContactBody>& bodies, ImpulseMemory& memory);

// Kept from step to step by a penalty pair.
struct PenaltyMemory {
  double stiffness = 0;  // k, force per length and node; 0: not yet found
  Index n_seen = 0;      // largest number of constraints so far
};

// `penalty`: p = k h max(0, -g) with g at the start of the step. With x = omega_max h a step of k h G G^T kicks and free motion is
// stable for k h lambda_max(W) <= 4 - x^2 (central differences; exact motion allows 2 + 2 cos x, which is more); k = penalty_share
// of that. k is found from the first contact and lowered when more nodes take part, so that a contact does not change its spring.
// `x` < 2.
constexpr double penalty_share = 0.2;
EnforcementResult enforce_penalty(const std::vector<Constraint>& constraints, double h, double x, std::vector<ContactBody>& bodies,
                                  PenaltyMemory& memory);

// `nodal`: what a code does that knows only nodal masses (method.md): the nodes' velocities alone are changed, each weighed by
// `masses` (per contact body m x 3, scene axes), so that no gap is negative at the end. Adds impulses; velocity changes are
// impulses / masses.
EnforcementResult enforce_nodal(const std::vector<Constraint>& constraints, const std::vector<char>& guess, double h,
                                const std::vector<Points>& masses, std::vector<ContactBody>& bodies);

}  // namespace cbr
