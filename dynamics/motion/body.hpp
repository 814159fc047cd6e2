// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/motion: what a body is; its damping, loads and moving supports.
//
// Something that moves, has nodes, and answers impulses on them. Bodies and their abilities
// (abilities.hpp) are the only abstract classes of the motion.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/types.hpp"
#include "dynamics/contact/nodes/node_response.hpp"
#include "dynamics/motion/abilities.hpp"
#include "dynamics/motion/body_load.hpp"
#include "dynamics/motion/body_readings.hpp"

namespace cbr {

// What a body is told before it moves.
struct BodyPlan {
  std::vector<BodyLoad> loads = {};
  // The step at which contact will push, omega_max h < pi; 0: none. Exact bodies then answer
  // impulses with the compliance of a force that lasts (contact_gain.hpp).
  double contact_step = 0;
  // rad/s. Where BodyFacts::scales, every mode above it gets this frequency by more modal mass;
  // statics, rigid motion and all other modes stay as they are.
  double clip = HUGE_VAL;
};

// All impulses (force x time) of contact on a set at once, at the start of the step: n x 3, scene
// axes; 0 rows: none.
struct Impulses {
  const Points& contact;
  const Points& friction;
  // response() of the step times both, and the part of it that the rows of static compliance have
  // (thin responses only). A body that needs these products need not compute them again. Null: not
  // known.
  const Points* move = nullptr;
  const Vector* still = nullptr;

  // take(impulses, kind) of both, where they are not zero.
  template <typename Take>
  void each(const Take& take) const {
    if (contact.rows() > 0 && !contact.isZero(0)) take(contact, ImpulseKind::contact);
    if (friction.rows() > 0 && !friction.isZero(0)) take(friction, ImpulseKind::friction);
  }
};

// How a body is advanced.
enum class Scheme : char { exact, central_difference, newmark };

// What never changes of a body.
struct BodyFacts {
  std::string name;
  Scheme scheme = Scheme::exact;
  Index n_dofs = 0;
  std::shared_ptr<const Points> positions;  // n_nodes x 3, scene axes, undeformed
  // Whether a thread may step it while others step other bodies: it changes nothing that it shares
  // with them, or under a lock. response() and motion bounds are asked by one thread alone.
  bool steps_alone = false;
  // The largest stable step in contact, as a share of the critical step: `step: auto` takes it.
  double contact_share = 1;
  bool scales = false;  // its modes, to BodyPlan::clip
};

// A body is made, told which nodes are asked for (track), told its loads (prepare), and stepped.
//
// A step goes: predict(t, h) computes the end of the step without contact; contact asks positions
// and response at the nodes it cares about and hands back impulses; accept() makes the end the new
// state. Nodes are indices 0 .. n_nodes() - 1.
class Body : public BodyReadings {
 public:
  const BodyFacts& facts() const { return facts_; }
  const std::string& name() const { return facts_.name; }
  Index n_dofs() const { return facts_.n_dofs; }
  Scheme scheme() const { return facts_.scheme; }
  // any step is allowed when no contact is near
  bool is_exact() const { return scheme() == Scheme::exact; }
  const Points& reference_positions() const { return *facts_.positions; }
  Index n_nodes() const { return reference_positions().rows(); }

  // rad/s, of the body alone; sets the step. That of a scaled one after prepare().
  virtual double largest_frequency() const = 0;

  // Number of a node set, for the calls below. Of a body that scales before prepare():
  // std::logic_error after it.
  virtual Index track(const std::vector<Index>& nodes) = 0;
  // Once, before the first step: std::logic_error otherwise. InputError: a load that it cannot
  // take.
  void prepare(const BodyPlan& plan);

  virtual void positions(Index set, Points& x) const = 0;  // now
  // at the end of the step, with the impulses added so far
  virtual void predicted_positions(Index set, Points& x) const = 0;
  // nothing moves it but impulses: a step leaves it as it is
  virtual bool at_rest() const { return false; }

  void predict(double t, double h);
  virtual void take_impulses(Index set, const Impulses& impulses) = 0;
  void add_impulses(Index set, const Points& impulses, ImpulseKind kind = ImpulseKind::contact);
  // Forces of contact on a set that go on through the next step: what `forces` has is force, not
  // impulse. Once the impulses of this step are in and before accept(); without a call there are
  // none. The next step moves under them, and its impulses are all of contact's, as ever: the body
  // feels what these change. docs/theory.md, "Forces that last".
  virtual void expect_forces(Index, const Impulses&) {}
  // Of the impulse of such a force over a step, which share the momentum between two steps has
  // before its impulse is given; < 0: lacks after it.
  virtual double lasting_share() const { return 0; }
  virtual void accept() = 0;

  // Change of the predicted positions of the set's dofs per unit impulse on them, for a step h.
  virtual NodeResponse response(Index set, double h) const = 0;

  // Between two steps: all that steps have made of the body, for a checkpoint
  // (common/files/state_archive.hpp). A body that was built in the same way and gets this goes on
  // bit for bit as this one.
  virtual void keep_state(StateArchive& archive) = 0;

  // Null if the body lacks the ability.
  virtual const BoundAbility* bounds() const { return nullptr; }
  virtual NodalAbility* nodal() { return nullptr; }
  virtual EndImpulseAbility* end_impulses() { return nullptr; }
  virtual StartImpulseAbility* start_impulses() { return nullptr; }
  virtual StaticsAbility* statics() { return nullptr; }
  virtual TurningAbility* turning() { return nullptr; }

 protected:
  explicit Body(BodyFacts facts) : facts_(std::move(facts)) {}

  virtual void take_plan(const BodyPlan& plan) = 0;
  // of the step from t_ to t_ + h_
  virtual void predict_end() = 0;

  BodyFacts facts_;
  double t_ = 0, h_ = 0;  // of the last step

 private:
  bool is_prepared_ = false, has_moved_ = false;
};

// InputError: the body has it not.
StaticsAbility& statics_of(Body& body);
NodalAbility& nodal_of(Body& body);

}  // namespace cbr
