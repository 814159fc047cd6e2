// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/motion: what a body is; its damping, loads and moving supports.
//
// Something that moves, has nodes, and answers impulses on them. Bodies and their abilities
// (abilities.hpp) are the only abstract classes of the motion.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/contact/nodes/node_response.hpp"
#include "dynamics/motion/abilities.hpp"
#include "dynamics/motion/damping.hpp"
#include "dynamics/motion/load_history.hpp"

namespace cbr {

class StateArchive;

// Nodal forces, n_nodes x 3, scene axes, and what they are beside that on the first of the modal
// coordinates (empty: nothing), for which see add_modal_force().
struct ForcePattern {
  Points forces;
  Vector modal = {};
};

// A load sum_a b_a P_a times a history. b is a vector in axes that turn with a body that turns: it
// is `value` where it follows the body, else what makes `value` in the scene's axes.
struct VectorLoad {
  std::array<ForcePattern, 3> patterns;  // P_a; forces of 0 rows: none
  Vector3 value = Vector3::Zero();
  bool follows = false;
  LoadHistory history;
};

// What a body answers about itself, all in the scene's axes.
struct BodyState {
  // angular_momentum: about the scene's origin, of the linearised motion (arms of the undeformed
  // body about its centre of mass).
  Vector3 center_of_mass = Vector3::Zero(), momentum = Vector3::Zero(),
          angular_momentum = Vector3::Zero();
  double kinetic_energy = 0, strain_energy = 0;
  // mean rotation since the start, rad: the formulation is linear, so it should stay small
  double rotation = 0;
  // Of a body that turns by any angle: unit quaternion w x y z since the start, scene axes.
  std::optional<Eigen::Vector4d> orientation = {};
  // kinetic + strain, of what moves with scaled modal mass: what that costs in accuracy at most
  double scaled_energy = 0;
};

// Work done on a body since the start of the run; kinetic + strain energy changes by their sum, to
// round-off.
struct BodyWork {
  double external = 0, contact = 0, friction = 0;
  // of the material's and the modes' damping: never above 0 but for changes of the step
  double damping = 0;
  // what the integrator takes or gives by itself: HHT-alpha's damping, central differences' changes
  // of step
  double numerical = 0;
};

// How a body is advanced.
enum class Scheme : char { exact, central_difference, newmark };

// A step goes: predict(t, h) computes the end of the step without contact; contact asks positions
// and response at the nodes it cares about and hands back impulses with add_impulses(); accept()
// makes the end the new state. Nodes are indices 0 .. n_nodes() - 1. Sets of nodes that are asked
// for often are announced once with track().
class Body {
 public:
  virtual ~Body() = default;

  virtual const std::string& name() const = 0;
  virtual Index n_dofs() const = 0;
  virtual double largest_frequency() const = 0;  // rad/s, of the body alone; sets the step
  virtual Scheme scheme() const = 0;
  // any step is allowed when no contact is near
  bool is_exact() const { return scheme() == Scheme::exact; }
  // Whether a thread may step it while others step other bodies: it changes nothing that it shares
  // with them, or under a lock. response() and motion bounds are asked by one thread alone.
  virtual bool steps_alone() const { return false; }
  // The largest stable step in contact, as a share of the critical step: `step: auto` takes it.
  virtual double contact_share() const { return 1; }
  // Before the first predict() and before scale(): the step at which contact will push, omega_max h
  // < pi. Exact bodies then answer impulses with the compliance of a force that lasts
  // (contact_gain.hpp).
  virtual void set_contact_step(double) {}
  // Once, before track(), loads and the first predict(). InputError: damping that this body does
  // not have.
  virtual void damp(const Damping& damping);

  virtual const Points& reference_positions() const = 0;  // n_nodes x 3, scene axes, undeformed
  Index n_nodes() const { return reference_positions().rows(); }

  // Number of a node set, for the calls below. Only before the first predict().
  virtual Index track(const std::vector<Index>& nodes) = 0;
  virtual void positions(Index set, Points& x) const = 0;  // now
  // at the end of the step, with the impulses added so far
  virtual void predicted_positions(Index set, Points& x) const = 0;
  // nothing moves it but impulses: a step leaves it as it is
  virtual bool at_rest() const { return false; }
  // The same for sets of which only the plain mean is asked for; their numbers are of mean_motion()
  // only.
  virtual Index track_mean(const std::vector<Index>& nodes) = 0;
  virtual void mean_motion(Index set, Vector3& position, Vector3& velocity) const = 0;

  virtual void predict(double t, double h) = 0;
  // Impulses (force x time) on the set's nodes at the start of the step: n x 3, scene axes.
  virtual void add_impulses(Index set, const Points& impulses, ImpulseKind kind) = 0;
  void add_impulses(Index set, const Points& impulses) {
    add_impulses(set, impulses, ImpulseKind::contact);
  }
  // All impulses of a step on the set at once. move: response() of the step times contact +
  // friction. still: the part of it that the rows of static compliance have (thin responses only).
  // A body that needs these products need not compute them again.
  virtual void add_answered_impulses(Index set, const Points& contact, const Points& friction,
                                     const Points& move, const Vector& still);
  virtual void accept() = 0;

  // Change of the predicted positions of the set's dofs per unit impulse on them, for a step h.
  virtual NodeResponse response(Index set, double h) const = 0;
  // Nodal forces (n_nodes x 3, scene axes) times a history; the same for an acceleration of the
  // whole body. Before the first predict().
  virtual void add_force(const Points& forces, const LoadHistory& history) = 0;
  virtual void add_gravity(const Vector3& acceleration, const LoadHistory& history) = 0;
  // Forces on the modal coordinates, the first ones of coordinates(): what a load inside a
  // superelement does to its modes. Before the first predict(). InputError: a body that has no such
  // coordinates of its own.
  virtual void add_modal_force(const Vector& forces, const LoadHistory& history);
  // Before the first predict(). Of a body that does not turn b is `value`.
  virtual void add_vector_load(const VectorLoad& load);

  virtual BodyState state() const = 0;
  virtual BodyWork work() const = 0;
  // of all nodes, and their velocities; scene axes, n_nodes x 3
  virtual void displacements(Points& u, Points& v) const = 0;
  // All coordinates and their rates, component axes: modal ones (of the parts one after the other),
  // then x, y, z of the nodes, then rotations of nodes. A recovery of interiors starts from them.
  virtual void coordinates(Vector& q, Vector& rates) const = 0;

  // What coordinates() does not show of a body that turns: u and v (n x 3, scene axes) of points X
  // of it (n x 3, undeformed, scene axes) become the whole displacements and velocities.
  virtual void turn(const Points& X, Points& u, Points& v) const;

  // Null: it has not the ability.
  virtual const BoundAbility* bounds() const { return nullptr; }
  virtual NodalAbility* nodal() { return nullptr; }
  virtual EndImpulseAbility* end_impulses() { return nullptr; }
  virtual StartImpulseAbility* start_impulses() { return nullptr; }
  virtual StaticsAbility* statics() { return nullptr; }
  virtual ScalingAbility* scaling() { return nullptr; }
  virtual TurningAbility* turning() { return nullptr; }

  // Between two steps: all that steps have made of the body, for a checkpoint
  // (common/files/state_archive.hpp). A body that was built in the same way and gets this goes on
  // bit for bit as this one.
  virtual void keep_state(StateArchive& archive) = 0;
};

// InputError: the body has it not.
StaticsAbility& statics_of(Body& body);
NodalAbility& nodal_of(Body& body);

void keep_state(StateArchive& archive, BodyState& state);
void keep_state(StateArchive& archive, BodyWork& work);

// Value of a history at time t: linear between its points, constant outside, 1 when it has none.
double history_value(const History& history, double t);

}  // namespace cbr
