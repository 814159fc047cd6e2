// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/enforce: impulse, penalty, nodal and ties; the state that contact
// keeps.
//
// From contact points to impulses: the three enforcements. All conserve linear momentum exactly:
// what the slave gets, the master gives.
#pragma once

#include <optional>
#include <vector>

#include "dynamics/contact/enforce/contact_unknowns.hpp"
#include "dynamics/contact/response/body_moves.hpp"
#include "dynamics/contact/solve/contact_solver.hpp"
#include "dynamics/contact/solve/defect_model.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// What one enforcement did in one step; rows go with the points, columns with their frames.
struct EnforcementResult {
  Points p;    // impulses
  Points gap;  // column 0: at the end of the step
  // of the laws, see ContactSolution; infinite: magnitudes beyond a double's reach, p = 0
  double residual = 0;
  bool fallback = false;
  // Of impulse with functions, by search: functions and points that could have an impulse
  std::vector<Index> n_unknowns = {};
  HeldPoints held = {};  // empty: none

  bool is_held(Index point) const { return held.pressure.size() > 0 && held.pressure[point] >= 0; }
  // Whether contact acts at a point: nodal forces of functions of corners may be negative.
  bool pushes(Index point) const {
    return p(point, 0) > 0 || (is_held(point) && (held.pressure[point] > 0 || p(point, 0) < 0));
  }
};

// Where a row of W_0 belongs: the slave's slot, which of its points, and between which bodies.
struct PointKey {
  Index slave = 0, master = 0, slot = 0, node = 0, ordinal = 0;
  ContactLaw law = ContactLaw::frictionless;
  bool operator==(const PointKey&) const = default;
};

// How a W_0 that is not quite that of the step is used.
struct CorrectionOptions {
  Index least_rows = 48;     // with fewer rows W is formed anew in each step
  double tolerance = 1e-11;  // of the laws with the true W, as a share of the largest |g|
};

// Kept from step to step by a group of points that is solved together.
struct ImpulseMemory {
  ContactList rows;  // those that W was formed from: W_0 when they are not those of the step
  std::vector<PointLaw> laws;
  double h = 0;
  std::optional<ContactSolver> solver;
  CorrectionOptions options;
  std::vector<PointKey> keys, new_keys;  // of the points of W_0; of the step
  DefectModel defects;                   // of W_0
  // of the last corrected step's first product, as a share of the largest |g|
  double first_error = 0;
  double extra = 0;  // products since W was formed beyond those that any W needs
  BodyMoves moves;   // of this step's impulses
  // steps in which W is formed anew without an attempt to keep it, once one has failed
  Index wait = 0, backoff = 1;
  // So far: times that W was formed, or points were added to or taken from it; corrected steps, and
  // their products
  Index n_formed = 0, n_changed = 0, n_steps = 0, n_pushes = 0;
  ContactUnknowns unknowns;  // of the last step in which there were fewer than points
  Vector x;                  // their impulses
  // Of `rows`: all functions, and what these and the unknowns are answered with
  SparseMatrix N;
  StandingResponse standing;
};

// `impulse`: 0 <= p, 0 <= g_end, p . g_end = 0 with g_end = g + W p the gap at the END of the step
// (Carpenter, Taylor, Katona 1991, doi 10.1002/nme.1620320107, with the bodies' full response);
// with friction, Coulomb's law for the slip over the step; tied points stay together. Adds to the
// bodies' impulses and fills their moves. `guess`: impulses of the last step (as
// EnforcementResult::p). W and its factor are kept while the rows of G stand. A dense W is kept
// also while they change little: with W_0 in its place the impulses leave a defect (W - W_0) p,
// which products with the bodies' own responses tell and the next solution takes into g, until the
// laws hold with W. `searches`: with functions, which are the unknowns where cells close
// (contact_unknowns.hpp): the laws hold for these, and gaps of single points differ from 0.
EnforcementResult enforce_impulse(const ContactList& list, const std::vector<PointLaw>& laws,
                                  const Points& guess, double h, std::vector<ContactBody>& bodies,
                                  ImpulseMemory& memory,
                                  const std::vector<FunctionsOfSearch>& searches = {});

// Newmark's contact closes gaps at the end of a step and would leave velocities of either sign
// there, which go on from step to step. So the velocities obey a law of their own: of the points
// with an impulse the total impulse P for which the laws hold with the velocities at the end of the
// step in the place of gaps, v_end + W_v (P - p), W_v = G M^-1 G^T (an inelastic impact of the
// nodes' own mass; positions and velocities apart: Bruels, Acary, Cardona 2014,
// doi 10.1016/j.cma.2014.07.025). Without friction it brings no energy; with friction the total
// impulse is within the cone, and what a smaller normal impulse gives back of the tangential one
// may speed up the slip that p had slowed down. `velocities`: relative ones of the points, in their
// frames, with p. The bodies' velocity_response must be there. Returns P - p, points x 3; infinite
// when W_v or the velocities are not finite. W_v and its factor are kept while the rows of the
// points with an impulse stand.
Points settle_velocities(const ContactList& list, const std::vector<PointLaw>& laws,
                         const Points& p, const Points& velocities,
                         const std::vector<ContactBody>& bodies, ImpulseMemory& memory);
// The same for unknowns that are reduced, p = A x; x is changed with p.
Points settle_unknowns(const ContactList& list, const std::vector<PointLaw>& laws,
                       const ContactUnknowns& unknowns, const Points& velocities,
                       const std::vector<ContactBody>& bodies, Vector& x, ImpulseMemory& memory);

// Kept from step to step by a penalty pair.
struct PenaltyMemory {
  double stiffness = 0;  // k, force per length and point; 0: not yet found
  double dashpot = 0;    // c, force per velocity and point
  Index n_seen = 0;      // largest number of points so far
};

// `penalty`: p_n = h max(0, -k g - c g') with g at the start of the step and g' over it. With x =
// omega_max h a step of k h G G^T kicks and free motion is stable for s = k h lambda_max(W) <= 4 -
// x^2 (central differences; exact motion allows 2 + 2 cos x, which is more), a dashpot c = 2 zeta
// sqrt(k h / lambda_max) for s + 4 zeta sqrt(s) <= 4 - x^2; s is taken from penalty_share of that.
// k is found from the first contact and lowered when more points take part, so that a contact does
// not change its spring. `x` < 2. Friction: tangential springs k whose stretch `elastic_slip`
// (points x 3, scene axes, at the start of the step) gives way at mu p_n.
constexpr double penalty_share = 0.2;
EnforcementResult enforce_penalty(const ContactList& list, const std::vector<PointLaw>& laws,
                                  double h, double x, double damping,
                                  std::vector<ContactBody>& bodies, PenaltyMemory& memory,
                                  Points& elastic_slip);

// `nodal`: what a code does that knows only nodal masses: the nodes' velocities alone are changed,
// each weighed by `masses` (per contact body m x 3, scene axes), so that no gap is negative at the
// end. Adds impulses; velocity changes are impulses / masses.
EnforcementResult enforce_nodal(const ContactList& list, const Points& guess, double h,
                                const std::vector<Points>& masses,
                                std::vector<ContactBody>& bodies);

}  // namespace cbr
