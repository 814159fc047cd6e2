// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/body.hpp"

#include <Eigen/Geometry>

#include <stdexcept>

#include "common/base/error.hpp"
#include "common/files/state_archive.hpp"

namespace cbr {

void Body::prepare(const BodyPlan& plan) {
  if (is_prepared_ || has_moved_)
    throw std::logic_error("Body::prepare() of '" + name() + "': it has its plan, or has moved");
  is_prepared_ = true;
  take_plan(plan);
}

void Body::predict(double t, double h) {
  has_moved_ = true;
  t_ = t;
  h_ = h;
  predict_end();
}

void Body::add_impulses(Index set, const Points& impulses, ImpulseKind kind) {
  const Points none(0, 3);
  const bool rubs = kind == ImpulseKind::friction;
  take_impulses(set, {rubs ? none : impulses, rubs ? impulses : none});
}

StaticsAbility& statics_of(Body& body) {
  if (StaticsAbility* statics = body.statics()) return *statics;
  throw InputError("instance '" + body.name() +
                   "': statics (time.static, time.preload) cannot be had of it");
}

NodalAbility& nodal_of(Body& body) {
  if (NodalAbility* nodal = body.nodal()) return *nodal;
  throw InputError("instance '" + body.name() +
                   "': enforcement: nodal has no masses of nodes to weigh with mass_scaling, "
                   "newmark, rotations: large, or an interface without mass: take enforcement "
                   "impulse or penalty");
}

void turn_points(const BodyTurn& turn, const Vector3& velocity, const Vector3& spin,
                 const Points& X, Points& u, Points& v) {
  for (Index i = 0; i < X.rows(); ++i) {
    const Vector3 arm = turn.R * (X.row(i) + u.row(i) - turn.center.transpose()).transpose();
    const Vector3 rate = turn.R * (v.row(i).transpose() - velocity);
    u.row(i) = (turn.center + arm).transpose() - X.row(i);
    v.row(i) = (velocity + spin.cross(arm) + rate).transpose();
  }
}

void keep_state(StateArchive& archive, BodyState& state) {
  archive(state.center_of_mass, state.momentum, state.angular_momentum, state.kinetic_energy,
          state.strain_energy);
  archive(state.rotation, state.scaled_energy);
  bool turns = state.orientation.has_value();
  archive(turns);
  if (!turns) return;
  Eigen::Vector4d orientation = state.orientation.value_or(Eigen::Vector4d::Zero());
  archive(orientation);
  state.orientation = orientation;
}

void keep_state(StateArchive& archive, BodyWork& work) {
  archive(work.external, work.contact, work.friction, work.damping, work.numerical);
}

}  // namespace cbr
