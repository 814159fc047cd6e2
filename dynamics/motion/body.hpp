// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/motion: the body, its damping, loads, supports and points.
//
// A body moves, has nodes, and responds to impulses on them. Body is the only abstract class of the
// motion.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "dynamics/contact/nodes/node_response.hpp"
#include "dynamics/contact/surfaces/motion_bound.hpp"
#include "dynamics/motion/body_readings.hpp"
#include "dynamics/motion/loads.hpp"

namespace cbr {

struct AveragePoint;
class BodyPoints;
class PrescribedMotion;
struct SupportPlan;

// Loads and the step of contact, given before the first step.
struct BodyPlan {
  std::vector<BodyLoad> loads = {};
  // The step at which contact acts, omega_max h < pi; 0: none. Exact bodies then respond to
  // impulses with the compliance of a lasting force (contact_gain()).
  double contact_step = 0;
};

// Impulses (force x time) of contact on a set, at the start of the step: n x 3, scene axes.
struct Impulses {
  const Points& all;
  // response() of the step times these, and its part of the residual compliance (thin responses
  // only), so that a body need not compute these products again. Null: not computed.
  const Points* move = nullptr;
  const Vector* still = nullptr;
};

// Time integration of a body.
enum class Scheme : char { exact, central_difference, newmark };

// Constants of a body.
struct BodyFacts {
  std::string name;
  Scheme scheme = Scheme::exact;
  Index n_dofs = 0;
  std::shared_ptr<const Points> positions;  // of its own nodes, n x 3, scene axes, undeformed
  // Whether a thread may step it while others step other bodies: it changes shared data only under
  // a lock. One thread alone calls response() and motion_bound().
  bool steps_alone = false;
  // The largest stable step in contact, as a share of the critical step: `step: auto` takes it.
  double contact_share = 1;
  bool kicks_at_end = false;  // impulses of contact act at the end of a step, not at its start
  bool bends = false;         // a link whose response to impulses depends on its motion
};

// Changes of an iteration towards equilibrium.
struct Settled {
  double change = 0;  // d . K d of its move d: twice an energy
  double energy = 0;  // u . K u
};

// R^T (f + contact), k, and the size of the terms of this sum.
struct FloatingForces {
  Vector sum;
  double largest = 0;
};

// Rotation of a floating frame: x = center + R (y - center), y the place of a point without it;
// scene axes.
struct BodyTurn {
  Vector3 center = Vector3::Zero();
  Matrix3 R = Matrix3::Identity();  // since the start
};

// Applies the rotation to u and v (n x 3, scene axes) of points X of a body (n x 3, undeformed).
// velocity, spin: of the centre, and rad/s.
void turn_points(const BodyTurn& turn, const Vector3& velocity, const Vector3& spin,
                 const Points& X, Points& u, Points& v);

// The order of calls: the constructor, supports and points, sets of nodes (track), loads (prepare),
// and steps.
//
// In a step predict(t, h) computes the end of the step without contact. Contact reads positions and
// the response of its nodes and gives impulses. accept() makes the end the new state. Nodes are
// indices 0 .. n_nodes() - 1: those of the body itself, then those of its points.
//
// Prescribed motion and points are data. The public functions apply them to the motion of the body
// itself, the virtual functions own_...: with supports at rest, on sets of nodes of the body
// itself.
class Body {
 public:
  virtual ~Body();
  const BodyFacts& facts() const { return facts_; }
  const std::string& name() const { return facts_.name; }
  Index n_dofs() const { return facts_.n_dofs; }
  Scheme scheme() const { return facts_.scheme; }
  // any step is allowed when no contact is near
  bool is_exact() const { return scheme() == Scheme::exact; }
  const Points& own_nodes() const { return *facts_.positions; }  // undeformed, without points
  const Points& reference_positions() const;                     // n_nodes x 3, undeformed
  Index n_nodes() const { return reference_positions().rows(); }

  // Before any set is tracked, supports first. The body is constrained there.
  void move_supports(SupportPlan plan);
  // InputError, with `where`: points whose nodes do not determine their motion.
  void add_points(std::vector<AveragePoint> points);
  // Null: none.
  const PrescribedMotion* supports() const { return supports_.get(); }
  const BodyPoints* points() const { return points_.get(); }
  BodyPoints* points() { return points_.get(); }
  // Of PrescribedMotion::sets(): means over [t - interval, t], the time since the last call; 0 if
  // interval is 0. And in statics, now.
  std::vector<Reaction> take_reactions(double t, double interval);
  std::vector<Reaction> static_reactions(double t) const;

  // rad/s, of the body alone; sets the step.
  virtual double largest_frequency() const = 0;

  // Number of a node set, for the calls below.
  Index track(const std::vector<Index>& nodes);
  // Once, before the first step: std::logic_error otherwise. InputError: a load that the body does
  // not support.
  void prepare(const BodyPlan& plan);

  void positions(Index set, Points& x) const;  // now
  // at the end of the step, with the impulses added so far
  void predicted_positions(Index set, Points& x) const;
  // Of exact bodies: bounds of the nodes after any time. quick: looser where that is cheaper.
  MotionBound motion_bound(Index set, bool quick = false) const;
  // a step without impulses does not change the state
  bool at_rest() const;

  // Impulses on all of coordinates(), component axes, that change the velocities at the start
  // without work. Before the first predict().
  virtual void add_start_impulse(const Vector& impulse);

  // n_steps: the regular steps that one jump over h replaces
  void predict(double t, double h, Index n_steps = 1);
  void take_impulses(Index set, const Impulses& impulses);
  void add_impulses(Index set, const Points& impulses) { take_impulses(set, {impulses}); }
  // Lasting forces of contact on a set through the next step, n x 3; 0 rows, or no call: none.
  // After the impulses of this step and before accept(). The next step moves under them; its
  // impulses are the total of contact, and the body takes the difference. docs/theory.md, "Forces
  // that last".
  void expect_forces(Index set, const Points& forces);
  // The share of such a force's impulse over a step that the momentum between two steps has before
  // the impulse is given; < 0: lacks after it.
  virtual double lasting_share() const { return 0; }
  // In each step, with the impulses of friction on a set (0 rows: none): work of friction on the
  // residual compliance, which follows forces with a lag, less the impulses' own on its velocity of
  // this step, or, with `between`, on the mean of this step and the last.
  double residual_friction(Index set, const Points& impulses, bool between);
  void accept();

  // Change of the predicted positions of the set's dofs per unit impulse on them, for a step h.
  NodeResponse response(Index set, double h) const;

  // For a nodal (kinematic) enforcement. InputError: the body has no masses of nodes.
  // The mass of each node and scene direction: row sums of the mass over the body's nodes, n x 3.
  virtual Points nodal_masses(Index set) const;
  // Changes the velocities of the set's nodes (n x 3, scene axes), and of no other coordinate, such
  // that the end moves by h times as much. Row sums are not all of the mass of this motion: a
  // uniform velocity of the set makes up the difference from `momentum`, and is returned. Not with
  // BodyPlan::contact_step.
  Vector3 add_velocities(Index set, const Points& velocities, const Vector3& momentum);

  // Of bodies under Newmark's method, after all impulses of the step and until accept().
  void end_velocities(Index set, Points& v);  // at the end of the step, scene axes
  // The change of these per unit impulse there, G M^-1 G^T.
  NodeResponse velocity_response(Index set) const;
  // Impulses at the end of the step: positions stay.
  void add_end_impulses(Index set, const Points& impulses);

  // Statics, without velocities: K u = f + contact. A load step is a number of iterations relax(),
  // forces of contact and moves, settle(), and end_load_step(). u = K^+ (f + contact) + R a with a
  // generalised inverse K^+ of the stiffness and the k motions R that it does not resist: the body
  // floats (Farhat, Roux 1991, doi 10.1002/nme.1620320604). K^+ excludes the inertial part of
  // forces that are not in equilibrium. R^T M R = m 1, m the mass, so that a is k lengths.
  // docs/theory.md, "Statics". InputError, of all: the body has no statics.
  //
  // The loads are those at time t, times share, and there is no contact. predicted_positions() are
  // then those of K^+ f + R a, with a as it was.
  void relax(double t, double share);
  Matrix floating_motions(Index set) const;  // R of the set, scene axes: 3 m x k
  virtual FloatingForces floating_forces() const;
  virtual void float_by(const Vector& move);  // a += move
  // K^+: change of the predicted positions of the set's dofs per unit force on them, and such
  // forces (n x 3, scene axes).
  NodeResponse static_response(Index set) const;
  void add_static_forces(Index set, const Points& forces);
  Settled settle();      // the predicted end becomes the state
  void end_load_step();  // books the work since the last one
  // After statics and before the first predict(), with its h: motion begins in equilibrium, under
  // the same forces of contact. loads: those that begin with it.
  void start_motion(double h, const std::vector<BodyLoad>& loads);

  // Whether it has large rotation. The functions below are of such bodies.
  virtual bool turns() const { return false; }
  // the rotation since the start of the axes of this step's response()
  virtual Matrix3 turn_of_step() const { return Matrix3::Identity(); }
  virtual BodyTurn turn_now() const { return {}; }
  // at the end of the step, with the impulses and moments added so far
  virtual BodyTurn turn_at_end() const { return {}; }
  virtual Vector3 spin() const { return Vector3::Zero(); }  // now, rad/s, scene axes
  // Displacements and velocities of the body's own nodes, without the rotation.
  virtual void unturned_displacements(Points& u, Points& v) const { displacements(u, v); }
  // A moment (times time) on the body, in addition to impulses on its nodes.
  virtual void add_moment(const Vector3& moment);

  // Outputs, between two steps.
  BodyState state() const;
  BodyWork work() const;  // work of supports is external
  // of the body's own nodes, and their velocities; scene axes
  void displacements(Points& u, Points& v) const;
  // All coordinates and their rates, component axes: modal ones (of the parts one after the other),
  // then x, y, z of the nodes, then rotations of nodes. A recovery of interiors starts from them.
  void coordinates(Vector& q, Vector& rates) const;
  // Adds the rotation of a body and the translation of its supports, which coordinates() excludes,
  // to u and v (n x 3, scene axes) of its points X (n x 3, undeformed, scene axes).
  void turn(const Points& X, Points& u, Points& v) const;
  // Number of a node set for mean_motion(); as track().
  Index track_mean(const std::vector<Index>& nodes);
  // the plain mean of its nodes
  void mean_motion(Index set, Vector3& position, Vector3& velocity) const;

  // Between two steps: the state, for a checkpoint (common/files/state_archive.hpp). A body that
  // was built in the same way continues from it bit for bit.
  void keep_state(StateArchive& archive);

 protected:
  explicit Body(BodyFacts facts);

  // Sets have the numbers 0, 1, ... in the order of the calls.
  virtual Index own_track(const std::vector<Index>& nodes) = 0;
  virtual Index own_track_mean(const std::vector<Index>& nodes) = 0;
  virtual void take_plan(const BodyPlan& plan) = 0;
  virtual void own_positions(Index set, Points& x) const = 0;
  virtual void own_predicted_positions(Index set, Points& x) const = 0;
  virtual MotionBound own_motion_bound(Index set, bool quick) const;
  virtual bool own_at_rest() const { return false; }
  // of the step from t_ to t_ + h_
  virtual void predict_end() = 0;
  virtual void own_take_impulses(Index set, const Impulses& impulses) = 0;
  virtual void own_expect_forces(Index, const Points&) {}
  virtual double own_residual_friction(Index, const Points&, bool) { return 0; }
  virtual void own_accept() = 0;
  virtual NodeResponse own_response(Index set, double h) const = 0;
  virtual Vector3 own_add_velocities(Index set, const Points& velocities, const Vector3& momentum);
  virtual void own_end_velocities(Index set, Points& v);
  virtual NodeResponse own_velocity_response(Index set) const;
  virtual void own_add_end_impulses(Index set, const Points& impulses);
  virtual void own_relax(double t, double share);
  virtual Matrix own_floating_motions(Index set) const;
  virtual NodeResponse own_static_response(Index set) const;
  virtual void own_add_static_forces(Index set, const Points& forces);
  virtual Settled own_settle();
  virtual void own_end_load_step();
  virtual void own_start_motion(double h, const std::vector<BodyLoad>& loads);
  // Of a set, without the rotation.
  virtual void unturned_positions(Index set, Points& x) const { own_positions(set, x); }
  virtual void unturned_end(Index set, Points& x) const { own_predicted_positions(set, x); }
  virtual NodeResponse unturned_response(Index set, double h) const { return own_response(set, h); }
  virtual BodyState own_state() const = 0;
  virtual BodyWork own_work() const = 0;
  virtual void own_displacements(Points& u, Points& v) const = 0;
  virtual void own_coordinates(Vector& q, Vector& rates) const = 0;
  virtual void own_turn(const Points& /*X*/, Points& /*u*/, Points& /*v*/) const {}
  virtual void own_mean_motion(Index set, Vector3& position, Vector3& velocity) const = 0;
  virtual void own_keep_state(StateArchive& archive) = 0;

  [[noreturn]] void lacks_statics() const;
  [[noreturn]] void lacks_nodal_masses() const;

  BodyFacts facts_;
  double t_ = 0, h_ = 0;  // of the last step
  Index n_steps_ = 1;

 private:
  [[noreturn]] void lacks(const char* ability) const;
  bool has_points(Index set) const;
  const Points& spread_on(Index set, const Points& impulses, Points& room) const;
  void push(Index set, const Impulses& impulses);
  Vector own_rates() const;

  std::unique_ptr<PrescribedMotion> supports_;
  std::unique_ptr<BodyPoints> points_;
  bool is_prepared_ = false, has_moved_ = false;
};

}  // namespace cbr
