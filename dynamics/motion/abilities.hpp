// SPDX-License-Identifier: GPL-3.0-or-later
// What some bodies can do beside moving under impulses. A body answers with the ability, or null if
// it lacks it (Body::statics() and so on). Scenes are checked for it before they run. A body that
// wraps another has an ability where that one has it, and forwards each function.
#pragma once

#include <vector>

#include "common/base/types.hpp"
#include "dynamics/contact/nodes/node_response.hpp"
#include "dynamics/contact/surfaces/motion_bound.hpp"

namespace cbr {

struct BodyLoad;

// What an impulse comes from: whose work it is.
enum class ImpulseKind : char { contact, friction };

// Of exact bodies: bounds on where nodes can be after any time.
class BoundAbility {
 public:
  virtual MotionBound motion_bound(Index set) const = 0;
  // looser where that is cheaper
  virtual MotionBound quick_motion_bound(Index set) const { return motion_bound(set); }

 protected:
  ~BoundAbility() = default;
};

// What a nodal (kinematic) enforcement needs.
class NodalAbility {
 public:
  // The mass of each node and scene direction: row sums of the mass over the body's nodes, n x 3.
  virtual Points nodal_masses(Index set) const = 0;
  // Changes the velocities of the set's nodes (n x 3, scene axes), and of no other coordinate, such
  // that the end moves by h times as much. Row sums do not tell all of the momentum that this
  // brings; what is missing from `momentum` is made up by a velocity that all nodes of the set get,
  // which is returned. Not with BodyPlan::contact_step.
  virtual Vector3 add_velocities(Index set, const Points& velocities, const Vector3& momentum) = 0;

 protected:
  ~NodalAbility() = default;
};

// Of bodies under Newmark's method, once all impulses of the step are in and until accept().
class EndImpulseAbility {
 public:
  // of the set's nodes at the end of the step, scene axes
  virtual void end_velocities(Index set, Points& v) = 0;
  // The change of these per unit impulse there, G M^-1 G^T.
  virtual NodeResponse velocity_response(Index set) const = 0;
  // Impulses at the end of the step: positions stay.
  virtual void add_end_impulses(Index set, const Points& impulses, ImpulseKind kind) = 0;

 protected:
  ~EndImpulseAbility() = default;
};

// What an iteration towards equilibrium has changed.
struct Settled {
  double change = 0;  // d . K d of its move d: twice an energy
  double energy = 0;  // u . K u
};

// R^T (f + contact), k, and how large the parts are that it is the sum of.
struct FloatingForces {
  Vector sum;
  double largest = 0;
};

// Statics, without velocities: K u = f + contact. A load step is a number of iterations relax(),
// forces of contact and moves, settle(), and end_load_step(). u = K^+ (f + contact) + R a with a
// generalised inverse K^+ of the stiffness and the k motions R that it does not resist: the body
// floats (Farhat, Roux 1991, doi 10.1002/nme.1620320604). K^+ leaves out what inertia would take of
// forces that are not in equilibrium. R^T M R = m 1, m the mass, so that a is k lengths.
// docs/theory.md, "Statics".
class StaticsAbility {
 public:
  // The loads are those at time t, times share, and there is no contact. predicted_positions() are
  // then those of K^+ f + R a, with a as it was.
  virtual void relax(double t, double share) = 0;
  virtual Matrix floating_motions(Index set) const = 0;  // R of the set, scene axes: 3 m x k
  virtual FloatingForces floating_forces() const = 0;
  virtual void float_by(const Vector& move) = 0;  // a += move
  // K^+: change of the predicted positions of the set's dofs per unit force on them, and such
  // forces (n x 3, scene axes).
  virtual NodeResponse static_response(Index set) const = 0;
  virtual void add_static_forces(Index set, const Points& forces, ImpulseKind kind) = 0;
  virtual Settled settle() = 0;      // the predicted end becomes the state
  virtual void end_load_step() = 0;  // books the work since the last one
  // Once statics are over, before the first predict(), with its h: motion begins in the state that
  // they have left, under the same forces of contact. loads: those that begin with it.
  virtual void start_motion(double h, const std::vector<BodyLoad>& loads) = 0;

 protected:
  ~StaticsAbility() = default;
};

// Of bodies that supports can move unevenly: impulses on all of coordinates(), component axes, that
// change the velocities at the start and are nobody's work. Before the first predict().
class StartImpulseAbility {
 public:
  virtual void add_start_impulse(const Vector& impulse) = 0;

 protected:
  ~StartImpulseAbility() = default;
};

// Where a body that turns has its points: x = center + R (y - center), y the place that the point
// would have without the turn; scene axes.
struct BodyTurn {
  Vector3 center = Vector3::Zero();
  Matrix3 R = Matrix3::Identity();  // since the start
};

// u and v (n x 3, scene axes) of points X of a body (n x 3, undeformed), as they would be without
// the turn, become as they are. velocity, spin: of the centre, and rad/s.
void turn_points(const BodyTurn& turn, const Vector3& velocity, const Vector3& spin,
                 const Points& X, Points& u, Points& v);

// Of bodies that turn by any angle.
class TurningAbility {
 public:
  // the rotation since the start in which this step's response() is
  virtual const Matrix3& turn_of_step() const = 0;
  virtual BodyTurn turn_now() const = 0;
  // at the end of the step, with the impulses and moments added so far
  virtual BodyTurn turn_at_end() const = 0;
  virtual Vector3 spin() const = 0;  // now, rad/s, scene axes
  // Positions of a set now and at the end of the step, and displacements and velocities of all
  // nodes, as they would be without the turn. Set: of the body's own track().
  virtual void unturned_positions(Index set, Points& x) const = 0;
  virtual void unturned_end(Index set, Points& x) const = 0;
  virtual void unturned_displacements(Points& u, Points& v) const = 0;
  virtual NodeResponse unturned_response(Index set, double h) const = 0;
  // A moment (times time) on the body beside impulses on its nodes.
  virtual void add_moment(const Vector3& moment, ImpulseKind kind) = 0;

 protected:
  ~TurningAbility() = default;
};

}  // namespace cbr
