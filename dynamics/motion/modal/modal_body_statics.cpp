// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement in equilibrium: its modes are uncoupled, so that nothing is solved.
#include <algorithm>
#include <cmath>

#include "dynamics/motion/modal/modal_body.hpp"

namespace cbr {

namespace {

// Of the highest omega^2: below, it is round-off of a mode without stiffness.
constexpr double no_stiffness = 1e-12;

}  // namespace

// The first modes, those of further parts of the body included.
Index ModalBody::n_floating() const {
  const auto omega2 = form_->omega.array().square();
  return std::max(form_->n_rigid,
                  (omega2 <= no_stiffness * (omega2.size() > 0 ? omega2.maxCoeff() : 0)).count());
}

void ModalBody::own_relax(double t, double share) {
  if (statics_.empty()) statics_.begin(now_.eta);
  flow_.loads().sum(t, f_);
  f_ *= share;
  statics_.begin_iteration(f_);
  end_.eta = now_.eta;
  const Index n = f_.size() - n_floating();
  end_.eta.tail(n) = f_.tail(n).array() / form_->omega.tail(n).array().square();
  residual_.relax(t, share);
}

ResponseOf ModalBody::static_response_of(Vector& weight) const {
  ResponseOf of;
  of.weight = ResponseOf::Weight::statics;
  of.h = 1;
  const Index n = n_floating();
  weight.setZero(form_->omega.size());
  weight.tail(weight.size() - n) = 1 / form_->omega.tail(weight.size() - n).array().square();
  return of;
}

NodeResponse ModalBody::own_static_response(Index set) const {
  Vector weight;
  const ResponseOf of = static_response_of(weight);
  if (!residual_.is_massless()) return answer(set, of, weight);
  NodeResponse response;
  response.set_block(*sets_[set].rows->response(of, weight) + residual_.compliance(set));
  response.axes = placement_.T;
  return response;
}

// Modes have a unit mass.
Matrix ModalBody::own_floating_motions(Index set) const {
  const Index n = n_floating();
  const auto Vt = sets_[set].rows->Vt();
  Matrix motions(Vt.cols(), n);
  for (Index i = 0; i < Vt.cols(); i += 3)
    motions.middleRows(i, 3) = std::sqrt(mass()) * placement_.T * Vt.block(0, i, n, 3).transpose();
  return motions;
}

FloatingForces ModalBody::floating_forces() const {
  const Vector f = std::sqrt(mass()) * (statics_.loads + statics_.contact);
  return {f.head(n_floating()), f.size() > 0 ? f.lpNorm<Eigen::Infinity>() : 0};
}

void ModalBody::float_by(const Vector& move) {
  end_.eta.head(move.size()) += std::sqrt(mass()) * move;
}

void ModalBody::own_add_static_forces(Index set, const Points& forces) {
  residual_.push(set, {forces});
  sets_[set].rows->kick(forces, placement_.T, local_, f_);
  statics_.add(f_);
  const Index n = f_.size() - n_floating();
  end_.eta.tail(n).array() += f_.tail(n).array() / form_->omega.tail(n).array().square();
}

Settled ModalBody::own_settle() {
  const auto omega2 = form_->omega.array().square();
  const Vector move = end_.eta - now_.eta;
  now_.eta = end_.eta;
  Settled settled{(omega2 * move.array().square()).sum(),
                  (omega2 * now_.eta.array().square()).sum()};
  residual_.settle(settled);
  return settled;
}

void ModalBody::own_end_load_step() {
  statics_.book(now_.eta, work_);
  residual_.end_load_step();
}

// Change of the rates by lasting forces of contact (empty: none), as impulses of steps h.
Vector ModalBody::contact_kick(double h, const Vector& force) const {
  if (force.size() == 0) return Vector::Zero(now_.eta.size());
  Vector kick = h * force;
  flow_.amplify(kick);
  return kick;
}

// With `exact` the forces of contact go on, at the ends of steps beside a massless interface.
// Newmark's impulses at the start of steps hold the body where it is at their ends, where it has
// half of a kick less than in the mean. With central differences its rates are those half a step
// before, of a body at rest under all forces.
void ModalBody::own_start_motion(double h, const std::vector<BodyLoad>& loads) {
  for (const BodyLoad& load : loads) take_load(load);
  residual_.start_motion(h, now_.eta);
  if (statics_.empty()) return;
  work_ = BodyWork();
  if (scheme() != Scheme::newmark) flow_.let_last(statics_.contact);
  if (scheme() == Scheme::newmark && newmark_.kicks_at_start(h))
    now_.v -= 0.5 * contact_kick(h, statics_.contact);
  if (scheme() == Scheme::central_difference) last_h_ = h;
  if (!facts_.kicks_at_end) return;
  late_.begin(now_.eta.size());
  if (is_exact()) return;
  late_.start = contact_kick(h, statics_.contact);
  now_.v += late_.start;
}

}  // namespace cbr
