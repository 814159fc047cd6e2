// SPDX-License-Identifier: GPL-3.0-or-later
// What each kind of body keeps from step to step. Not what it is built of, nor what follows from that and the length of a step.
#include "common/files/state_archive.hpp"
#include "dynamics/motion/coupled/coupled_body.hpp"
#include "dynamics/motion/modal/statics_body.hpp"
#include "dynamics/motion/modal/superelement_body.hpp"
#include "dynamics/motion/nodal/mesh_body.hpp"
#include "dynamics/motion/scaled/scaled_body.hpp"

namespace cbr {

void keep_state(StateArchive& archive, BodyState& state) {
  archive(state.center_of_mass, state.momentum, state.angular_momentum, state.kinetic_energy, state.strain_energy);
  archive(state.rotation, state.scaled_energy);
  bool turns = state.orientation.has_value();
  archive(turns);
  if (!turns) return;
  Eigen::Vector4d orientation = state.orientation.value_or(Eigen::Vector4d::Zero());
  archive(orientation);
  state.orientation = orientation;
}

void keep_state(StateArchive& archive, BodyWork& work) { archive(work.external, work.contact, work.friction, work.damping, work.numerical); }

void SuperelementBody::keep_state(StateArchive& archive) {
  archive.expect(eta_.size());
  archive(eta_, v_, t_, last_h_, work_);
  // Newmark: the end of a step gives the next one its accelerations and loads; HHT-alpha looks back one step more
  archive(started_, arrived_, a_, f0_, move_, load_change_);
  archive(late_kick_, late_friction_);
  if (late_end_kick_.size() != late_kick_.size())
    for (Vector* kick : {&late_end_kick_, &late_end_friction_}) kick->setZero(late_kick_.size());
  archive(statics_);
}

void StaticsBody::keep_state(StateArchive& archive) {
  modal_.keep_state(archive);
  archive.expect(static_cast<Index>(sets_.size()));
  archive(g_, g_before_, eta_before_, loads_now_, t_, h_, work_, was_in_contact_, has_force_, still_left_);
  for (NodeSet& set : sets_) archive(set.w, set.force, set.friction);
  bool is_still = load_step_.g.size() > 0;
  archive(is_still);
  if (is_still && archive.restores()) keep_load_step();
}

void ScaledBody::keep_state(StateArchive& archive) {
  if (!modes_) scale(HUGE_VAL);  // as the first step does
  archive.expect(now_.eta.size());
  archive.expect(now_.r.size());
  archive(now_.eta, now_.v, now_.r, now_.dr, now_.y, now_.dy, t_, work_);
}

// K u is formed anew where it was known: from it and in the pass that forms it velocities are the same, but not when it is formed.
void MeshBody::keep_state(StateArchive& archive) {
  archive.expect(u_.rows());
  archive(u_, v_, t_, last_h_, work_);
  bool is_known = Ku_is_current_;
  archive(is_known);
  if (!archive.restores()) return;
  Ku_is_current_ = v_now_is_current_ = false;
  if (is_known) internal_forces();
}

void CoupledBody::keep_state(StateArchive& archive) {
  archive.expect(u_.size());
  archive(u_, p_, v_, t_, last_h_, work_);
  archive(started_, arrived_, F_, Ma_, f0_, a_, last_change_of_Ku_, last_change_of_f_, a0_Ma0_);
  archive(Cv_, statics_);
  if (archive.restores()) Ku_is_current_ = v_now_is_current_ = false;
}

}  // namespace cbr
