// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/body.hpp"

#include <Eigen/Geometry>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/files/state_archive.hpp"

namespace cbr {

double history_value(const History& history, double t) {
  if (history.time.empty()) return 1;
  if (t <= history.time.front()) return history.value.front();
  if (t >= history.time.back()) return history.value.back();
  const auto after =
      std::upper_bound(history.time.begin(), history.time.end(), t) - history.time.begin();
  const double t0 = history.time[after - 1], t1 = history.time[after];
  return history.value[after - 1] +
         (history.value[after] - history.value[after - 1]) * (t - t0) / (t1 - t0);
}

void Body::add_answered_impulses(Index set, const Points& contact, const Points& friction,
                                 const Points&, const Vector&) {
  if (!contact.isZero(0)) add_impulses(set, contact, ImpulseKind::contact);
  if (!friction.isZero(0)) add_impulses(set, friction, ImpulseKind::friction);
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

void Body::add_modal_force(const Vector&, const LoadHistory&) {
  throw InputError("instance '" + name() +
                   "': a load on faces inside the part acts on superelements of basis "
                   "craig-bampton without mass_scaling only: take "
                   "the faces into the interface");
}

void Body::add_vector_load(const VectorLoad& load) {
  Points forces;
  Vector modal;
  for (Index a = 0; a < 3; ++a) {
    const ForcePattern& pattern = load.patterns[a];
    if (forces.rows() == 0) forces.setZero(pattern.forces.rows(), 3);
    if (load.value[a] == 0) continue;
    if (pattern.forces.rows() > 0) forces += load.value[a] * pattern.forces;
    if (pattern.modal.size() == 0) continue;
    if (modal.size() == 0) modal.setZero(pattern.modal.size());
    modal += load.value[a] * pattern.modal;
  }
  add_force(forces, load.history);
  if (modal.size() > 0) add_modal_force(modal, load.history);
}
void Body::damp(const Damping&) {
  throw InputError("instance '" + name() +
                   "': damping cannot be had with time.mass_scaling: leave one of the two out");
}

void Body::turn(const Points&, Points&, Points&) const {}

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
