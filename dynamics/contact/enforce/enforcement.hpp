// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/enforce: impulse, penalty, nodal and ties; the persistent state of
// contact.
//
// From contact points to impulses: the three enforcements. All conserve linear momentum exactly, as
// slave and master get opposite impulses.
#pragma once

#include <optional>
#include <vector>

#include "common/base/force_table.hpp"
#include "dynamics/contact/enforce/contact_unknowns.hpp"
#include "dynamics/contact/response/body_moves.hpp"
#include "dynamics/contact/solve/contact_solver.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// Largest residual without a warning.
inline constexpr double good_residual = 1e-6;

// Result of one enforcement in one step; rows: points, columns: axes of their frames.
struct EnforcementResult {
  Points p;    // impulses
  Points gap;  // column 0: at the end of the step
  // of the laws, see ContactSolution; infinite: overflow, p = 0
  double residual = 0;
  bool fallback = false;
  // Impulse with functions, by search: number of functions and points that may have an impulse
  std::vector<Index> n_unknowns = {};
  HeldPoints held = {};  // empty: none

  bool is_held(Index point) const { return held.pressure.size() > 0 && held.pressure[point] >= 0; }
  // Whether contact acts at a point: on second-order faces functions have nodal forces below 0.
  bool pushes(Index point) const {
    return p(point, 0) != 0 || (is_held(point) && held.pressure[point] > 0);
  }
};

// State of a group of points that is solved together, kept between steps.
struct ImpulseMemory {
  ContactList rows;  // of W
  std::vector<PointLaw> laws;
  double h = 0;
  std::optional<ContactSolver> solver;
  BodyMoves moves;           // of this step's impulses
  Index n_formed = 0;        // W formed so far
  ContactUnknowns unknowns;  // of the last step with fewer unknowns than points
  Vector x;                  // their impulses
  // For `rows`: all functions, and responses to them and to the unknowns
  SparseMatrix N;
  StandingResponse standing;
  // Points on planar walls have the same axes. If their only body has large rotation, `rows` and
  // `standing` are along its axes, three rows for each point; `axes`: rows, of the points in these
  bool rotates = false;
  Matrix3 axes = Matrix3::Identity();
};

// The laws of this step, at points with those of the last one but for the coefficients of friction.
inline void take_friction(const std::vector<PointLaw>& laws, ImpulseMemory& memory) {
  memory.laws = laws;
  memory.solver->take_friction(laws);
}

// `impulse`: 0 <= p, 0 <= g_end, p . g_end = 0 with g_end = g + W p the gap at the END of the step.
// As in Carpenter, Taylor, Katona 1991, doi 10.1002/nme.1620320107, with the bodies' full response.
// With friction, Coulomb's law for the slip in the step; tied points stay together. Adds to the
// bodies' impulses and fills their moves. `guess`: impulses of the last step (as
// EnforcementResult::p). W and its factor are reused while the rows of G do not change. With
// `searches` that have functions, these are the unknowns in closed cells (contact_unknowns.hpp).
// The laws then hold for functions, and gaps of single points differ from 0.
EnforcementResult enforce_impulse(const ContactList& list, const std::vector<PointLaw>& laws,
                                  const Points& guess, double h, std::vector<ContactBody>& bodies,
                                  ImpulseMemory& memory,
                                  const std::vector<FunctionsOfSearch>& searches = {});

// Corrects velocities at closed points for Newmark. Closing gaps at the end of a step would leave
// velocities of either sign, which persist from step to step. So velocities satisfy laws of their
// own, with total impulses P at the points with an impulse. The laws hold with v_end + W_v (P - p)
// in the place of gaps, W_v = G M^-1 G^T. This is an inelastic impact of the nodes' own mass, with
// positions and velocities separate: Bruels, Acary, Cardona 2014, doi 10.1016/j.cma.2014.07.025.
// Without friction it adds no energy. With friction the total impulse is within the cone. If the
// normal impulse decreases, so does the tangential one, which may speed up the slip that p had
// reduced. `velocities`: relative ones of the points, in their frames, with p. Needs the bodies'
// velocity_response. Returns P - p, points x 3; infinite if W_v or the velocities are not finite.
// W_v and its factor are reused while the rows of points with an impulse do not change.
Points settle_velocities(const ContactList& list, const std::vector<PointLaw>& laws,
                         const Points& p, const Points& velocities,
                         const std::vector<ContactBody>& bodies, ImpulseMemory& memory);
// The same for reduced unknowns, p = A x; changes x together with p.
Points settle_unknowns(const ContactList& list, const std::vector<PointLaw>& laws,
                       const ContactUnknowns& unknowns, const Points& velocities,
                       const std::vector<ContactBody>& bodies, Vector& x, ImpulseMemory& memory);

// State of a penalty pair, kept between steps.
struct PenaltyMemory {
  double stiffness = 0;              // k, force per length and point; 0: not yet found
  double dashpot = 0;                // c, force per velocity and point
  Index n_seen = 0;                  // largest number of points so far
  double most_stiffness = HUGE_VAL;  // beyond it a step is unstable
};

// `penalty`: p_n = h max(0, -k g - c g') with g at the start of the step and g' in it. Let x =
// omega_max h. A step of impulses k h G G^T and free motion is stable for s = k h lambda_max(W) <=
// 4 - x^2, by central differences. Exact motion allows the larger 2 + 2 cos x. With a dashpot c = 2
// zeta sqrt(k h / lambda_max) it is stable for s + 4 zeta sqrt(s) <= 4 - x^2. s is penalty_share of
// that limit: at the limit a contact lasts one step, at a fifth of it 3.4 or more. k is set at the
// first contact and reduced only when the number of points grows, so that a contact keeps its
// spring. A given `pressure` over depth, per area of the points and times `share`, takes the place
// of k; with a steepest slope beyond the stable limit p is infinite. `x` < 2. Friction: tangential
// springs k with extension `elastic_slip` (points x 3, scene axes, at the start of the step), which
// slide at mu p_n.
constexpr double penalty_share = 0.2;
struct PenaltyLaw {
  double damping = 0;
  ForceTable pressure = {};  // empty: none
  double share = 1;
};
EnforcementResult enforce_penalty(const ContactList& list, const std::vector<PointLaw>& laws,
                                  double h, double x, const PenaltyLaw& law,
                                  std::vector<ContactBody>& bodies, PenaltyMemory& memory,
                                  Points& elastic_slip);

// `nodal`: models codes with nodal masses only. Changes nodal velocities, weighted by `masses` (per
// contact body m x 3, scene axes), so that no gap is negative at the end. Adds impulses; velocity
// changes are impulses / masses.
EnforcementResult enforce_nodal(const ContactList& list, const Points& guess, double h,
                                const std::vector<Points>& masses,
                                std::vector<ContactBody>& bodies);

// For checkpoints, without the workspace that each step fills anew. W and its factors as they are:
// they result from updates over steps, and a new computation would differ in the last digits.
void keep_state(StateArchive& archive, PenaltyMemory& memory);
void keep_state(StateArchive& archive, ImpulseMemory& memory);
void keep_state(StateArchive& archive, ContactBody& body);  // without responses

}  // namespace cbr
