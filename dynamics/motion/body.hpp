// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/motion: what a body is; its damping, loads, supports and points.
//
// Something that moves, has nodes, and answers impulses on them. Body is the only abstract class of
// the motion.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/types.hpp"
#include "dynamics/contact/nodes/node_response.hpp"
#include "dynamics/contact/surfaces/motion_bound.hpp"
#include "dynamics/motion/body_load.hpp"
#include "dynamics/motion/body_readings.hpp"

namespace cbr {

struct AveragePoint;
class BodyPoints;
class PrescribedMotion;
struct SupportPlan;

// What a body is told before it moves.
struct BodyPlan {
  std::vector<BodyLoad> loads = {};
  // The step at which contact will push, omega_max h < pi; 0: none. Exact bodies then answer
  // impulses with the compliance of a force that lasts (contact_gain.hpp).
  double contact_step = 0;
};

// Impulses (force x time) of contact on a set, at the start of the step: n x 3, scene axes.
struct Impulses {
  const Points& all;
  // response() of the step times these, and the part of it that the rows of static compliance have
  // (thin responses only). A body that needs these products need not compute them again. Null: not
  // known.
  const Points* move = nullptr;
  const Vector* still = nullptr;
};

// How a body is advanced.
enum class Scheme : char { exact, central_difference, newmark };

// What never changes of a body.
struct BodyFacts {
  std::string name;
  Scheme scheme = Scheme::exact;
  Index n_dofs = 0;
  std::shared_ptr<const Points> positions;  // of its own nodes, n x 3, scene axes, undeformed
  // Whether a thread may step it while others step other bodies: it changes nothing that it shares
  // with them, or under a lock. response() and motion bounds are asked by one thread alone.
  bool steps_alone = false;
  // The largest stable step in contact, as a share of the critical step: `step: auto` takes it.
  double contact_share = 1;
  bool kicks_at_end = false;  // impulses of contact act at the end of a step, not at its start
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

// A body is made, gets supports and points, is told which nodes are asked for (track), told its
// loads (prepare), and stepped.
//
// A step goes: predict(t, h) computes the end of the step without contact; contact asks positions
// and response at the nodes it cares about and hands back impulses; accept() makes the end the new
// state. Nodes are indices 0 .. n_nodes() - 1: those of the body itself, then those of its points.
//
// Supports' motion and points are data. The public functions apply them to what the body itself
// does, which are the virtual functions own_...: without the motion of supports, and on sets of
// nodes of the body itself.
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

  // Before any set is tracked, supports first. The body is held where they are.
  void move_supports(SupportPlan plan);
  // InputError, with `where`: points that their nodes do not determine.
  void add_points(std::vector<AveragePoint> points, const std::string& where);
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
  // Once, before the first step: std::logic_error otherwise. InputError: a load that it cannot
  // take.
  void prepare(const BodyPlan& plan);

  void positions(Index set, Points& x) const;  // now
  // at the end of the step, with the impulses added so far
  void predicted_positions(Index set, Points& x) const;
  // Of exact bodies: where the nodes can be after any time. quick: looser where that is cheaper.
  MotionBound motion_bound(Index set, bool quick = false) const;
  // nothing moves it but impulses: a step leaves it as it is
  bool at_rest() const;

  // Impulses on all of coordinates(), component axes, that change the velocities at the start and
  // are nobody's work. Before the first predict().
  virtual void add_start_impulse(const Vector& impulse);

  void predict(double t, double h);
  void take_impulses(Index set, const Impulses& impulses);
  void add_impulses(Index set, const Points& impulses) { take_impulses(set, {impulses}); }
  // Forces of contact on a set that go on through the next step, n x 3; 0 rows: none. Once the
  // impulses of this step are in and before accept(); without a call there are none. The next step
  // moves under them, and its impulses are all of contact's, as ever: the body feels what these
  // change. docs/theory.md, "Forces that last".
  void expect_forces(Index set, const Points& forces);
  // Of the impulse of such a force over a step, which share the momentum between two steps has
  // before its impulse is given; < 0: lacks after it.
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
  // that the end moves by h times as much. Row sums do not tell all of the momentum that this
  // brings; what is missing from `momentum` is made up by a velocity that all nodes of the set get,
  // which is returned. Not with BodyPlan::contact_step.
  Vector3 add_velocities(Index set, const Points& velocities, const Vector3& momentum);

  // Of bodies under Newmark's method, once all impulses of the step are in and until accept().
  void end_velocities(Index set, Points& v);  // at the end of the step, scene axes
  // The change of these per unit impulse there, G M^-1 G^T.
  NodeResponse velocity_response(Index set) const;
  // Impulses at the end of the step: positions stay.
  void add_end_impulses(Index set, const Points& impulses);

  // Statics, without velocities: K u = f + contact. A load step is a number of iterations relax(),
  // forces of contact and moves, settle(), and end_load_step(). u = K^+ (f + contact) + R a with a
  // generalised inverse K^+ of the stiffness and the k motions R that it does not resist: the body
  // floats (Farhat, Roux 1991, doi 10.1002/nme.1620320604). K^+ leaves out what inertia would take
  // of forces that are not in equilibrium. R^T M R = m 1, m the mass, so that a is k lengths.
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
  // Once statics are over, before the first predict(), with its h: motion begins in the state that
  // they have left, under the same forces of contact. loads: those that begin with it.
  void start_motion(double h, const std::vector<BodyLoad>& loads);

  // Whether it turns by any angle. The functions below are of bodies that do.
  virtual bool turns() const { return false; }
  // the rotation since the start in which this step's response() is
  virtual Matrix3 turn_of_step() const { return Matrix3::Identity(); }
  virtual BodyTurn turn_now() const { return {}; }
  // at the end of the step, with the impulses and moments added so far
  virtual BodyTurn turn_at_end() const { return {}; }
  virtual Vector3 spin() const { return Vector3::Zero(); }  // now, rad/s, scene axes
  // Displacements and velocities of the body's own nodes, as they would be without the turn.
  virtual void unturned_displacements(Points& u, Points& v) const { displacements(u, v); }
  // A moment (times time) on the body, beside impulses on its nodes.
  virtual void add_moment(const Vector3& moment);

  // What outputs read between two steps.
  BodyState state() const;
  BodyWork work() const;  // what supports do is external
  // of the body's own nodes, and their velocities; scene axes
  void displacements(Points& u, Points& v) const;
  // All coordinates and their rates, component axes: modal ones (of the parts one after the other),
  // then x, y, z of the nodes, then rotations of nodes. A recovery of interiors starts from them.
  void coordinates(Vector& q, Vector& rates) const;
  // Adds what coordinates() leaves out, the turn of a body and the translation of its supports, to
  // u and v (n x 3, scene axes) of its points X (n x 3, undeformed, scene axes).
  void turn(const Points& X, Points& u, Points& v) const;
  // Number of a node set for mean_motion(); as track().
  Index track_mean(const std::vector<Index>& nodes);
  // the plain mean of its nodes
  void mean_motion(Index set, Vector3& position, Vector3& velocity) const;

  // Between two steps: all that steps have made of the body, for a checkpoint
  // (common/files/state_archive.hpp). A body that was built in the same way and gets this goes on
  // bit for bit as this one.
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
  // Of a set, as they would be without the turn.
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
