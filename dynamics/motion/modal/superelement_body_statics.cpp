// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement in equilibrium: its modes are uncoupled, so that nothing is solved.
#include <cmath>

#include "dynamics/motion/modal/superelement_body.hpp"

namespace cbr {

// Of rigid motions, and 0 where supports hold them all.
double SuperelementBody::static_pull() const {
  const Index n_rigid = form_->n_rigid;
  if (n_rigid == 0 || form_->omega.size() == 0) return 0;
  if (n_rigid == form_->omega.size()) return 1;  // nothing elastic to compare with
  const double omega = form_->omega[n_rigid];
  return static_pull_share * omega * omega;
}

// (omega^2 + sigma) eta_end = f + sigma eta
void SuperelementBody::relax(const Rest& rest) {
  if (statics_.empty()) statics_.begin(eta_);
  load_amplitudes(rest.t, f_);
  f_ *= rest.share;
  pull_ = static_pull() * rest.hold;
  eta_end_ = (f_ + pull_ * eta_).array() / (form_->omega.array().square() + pull_);
  statics_.begin_iteration(f_);
}

ResponseOf SuperelementBody::static_response_of(double hold, Vector& weight) const {
  ResponseOf of;
  of.weight = ResponseOf::Weight::statics;
  of.h = 1;
  of.theta = static_pull() * hold;
  weight = 1 / (form_->omega.array().square() + of.theta);
  return of;
}

NodeResponse SuperelementBody::static_response(Index set, double hold) const {
  Vector weight;
  const ResponseOf of = static_response_of(hold, weight);
  return answer(*sets_[set].rows, of, weight);
}

void SuperelementBody::add_static_forces(Index set, const Points& forces, ImpulseKind kind) {
  sets_[set].rows->kick(forces, placement_.T, local_, f_);
  statics_.add(f_, kind);
  eta_end_.array() += f_.array() / (form_->omega.array().square() + pull_);
}

Settled SuperelementBody::settle() {
  const auto omega2 = form_->omega.array().square();
  const Vector move = eta_end_ - eta_;
  Settled settled;
  settled.change = ((omega2 + pull_) * move.array().square()).sum();
  settled.energy = (omega2 * eta_end_.array().square()).sum();
  settled.way = move.norm() / std::sqrt(mass());
  eta_ = eta_end_;
  return settled;
}

void SuperelementBody::end_load_step() { statics_.book(eta_, work_); }

// What forces of contact that last do to the rates, as impulses of steps h.
Vector SuperelementBody::contact_kick(double h, const Vector& force) const {
  Vector kick = h * force;
  if (gain_.size() > 0) kick.array() *= gain_.array();
  return kick;
}

// With `exact` the forces of contact go on. Newmark's impulses at the start of steps hold the body
// where it is at their ends, where it has half of a kick less than in the mean. With central
// differences its rates are those half a step before, of a body at rest under all forces.
void SuperelementBody::start_motion(double h, const std::vector<BodyLoad>& loads) {
  for (const BodyLoad& load : loads) take_load(load);
  if (statics_.empty()) return;
  work_ = BodyWork();
  if (scheme() != Scheme::newmark) let_last(statics_.contact, statics_.friction);
  if (scheme() == Scheme::newmark && kicks_at_start(h))
    v_ -= 0.5 * contact_kick(h, statics_.contact + statics_.friction);
  if (scheme() == Scheme::central_difference) last_h_ = h;
}

void SuperelementBody::start_late_motion(double h, const std::vector<BodyLoad>& loads) {
  for (const BodyLoad& load : loads) take_load(load);
  if (statics_.empty()) return;
  work_ = BodyWork();
  let_last(statics_.contact, statics_.friction);
  for (Vector* kick : {&late_.all, &late_.friction, &late_end_.all, &late_end_.friction})
    kick->setZero(eta_.size());
  if (is_exact()) return;
  late_.friction = contact_kick(h, statics_.friction);
  late_.all = contact_kick(h, statics_.contact) + late_.friction;
  v_ += late_.all;
  last_h_ = h;
}

}  // namespace cbr
