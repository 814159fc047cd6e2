// SPDX-License-Identifier: GPL-3.0-or-later
// Modes with damping, eta'' + c eta' + omega^2 eta = f, in each scheme.
#include "dynamics/motion/modal/superelement_body.hpp"

namespace cbr {

std::shared_ptr<const ModalPropagator> SuperelementBody::make_propagator(double h) const {
  if (is_damped()) return form_->shared.propagator(form_->omega, damping_, h, may_be_driven());
  return form_->shared.propagator(form_->omega, h, may_be_driven());
}

// Kinetic and strain energy of such a motion.
double SuperelementBody::flow_energy(const Vector& eta, const Vector& v) const {
  const Vector forces = form_->omega.cwiseProduct(eta);
  return 0.5 * (v.squaredNorm() + forces.squaredNorm());
}

// Central differences: what a kick at the start of the step leaves in the rates at its middle.
Vector SuperelementBody::kicked_by(const Vector& kick) const {
  return kick.array() / (1 + 0.5 * h_ * damping_.c.array());
}

// Leapfrog with the damping of half a step on each side of t, so that the critical step stays:
//   (1 + c h / 2) v+ = (1 - c h- / 2) v- + (h- + h)/2 (f - omega^2 eta).
// f_ holds the loads.
void SuperelementBody::predict_central_damped() {
  f_ -= form_->omega.cwiseAbs2().cwiseProduct(eta_);
  const auto c = damping_.c.array();
  if (last_h_ == 0) {
    // The half kick back is booked as work of the loads and of damping: the energy balance starts
    // from the given velocity.
    const Vector all = f_.array() - c * v_.array();
    const double of_loads = 0.5 * h_ * f_.dot(0.25 * h_ * f_ - v_);
    work_.external += of_loads;
    work_.damping += 0.5 * h_ * all.dot(0.25 * h_ * all - v_) - of_loads;
    v_ -= 0.5 * h_ * all;
    last_h_ = h_;
  }
  // Forces at the end of the last step are a kick at the start of this one
  const bool late = late_.size() > 0;
  if (late) v_ -= late_;
  v_end_ = (1 - 0.5 * last_h_ * c) * v_.array() + 0.5 * (last_h_ + h_) * f_.array();
  if (late) {
    v_end_ += late_;
    v_ += late_;
  }
  v_end_.array() /= 1 + 0.5 * h_ * c;
  eta_end_ = eta_ + h_ * v_end_;
}

// As without damping (superelement_body_newmark.cpp), the rate at the end being taken from the move
// d: v_1 = 2 d / h - v_0. So damping is a stiffness 2 c / h more and a force:
//   a_1 = e - (1 + alpha) (omega^2 + 2 c / h) d,   e = (1 + alpha) (f_1 + 2 c v_0) - alpha f_0 -
//   omega^2 eta_0 - c v_0.
void SuperelementBody::predict_newmark_damped(double h) {
  const auto omega2 = form_->omega.array().square();
  const auto c = damping_.c.array();
  const double alpha = newmark_.alpha, beta = newmark_.beta();
  if (!started_) {
    load_amplitudes(t_, f0_);
    a_ = f0_.array() - omega2 * eta_.array() - c * v_.array();
    move_.setZero(eta_.size());
    load_change_.setZero(eta_.size());
    started_ = true;
  }
  load_amplitudes(t_ + h, f1_);
  e_ = (1 + alpha) * f1_.array() - alpha * f0_.array() - omega2 * eta_.array() +
       (1 + 2 * alpha) * c * v_.array();
  d_ = newmark_weight(h).array() * (v_ + h * ((0.5 - beta) * a_ + beta * e_)).array();
  eta_end_ = eta_ + d_;
}

// With alpha = 0 the energy changes by the loads' and impulses' work along the move and by -c d^2 /
// h of each mode. With another alpha what is left is the scheme's own.
void SuperelementBody::accept_newmark_damped() {
  const auto omega2 = form_->omega.array().square();
  const auto c = damping_.c.array();
  const double alpha = newmark_.alpha, beta = newmark_.beta(), gamma = newmark_.gamma();
  const double before = flow_energy(eta_, v_);
  e_.array() -= (1 + alpha) * (omega2 + 2 / h_ * c) * d_.array();  // a_1
  for (Index j = 0; j < eta_.size(); ++j) {
    const double kick = kicked_ ? kick_[j] : 0;
    if (newmark_weight_[j] > 0.01 * h_) {
      v_end_[j] = v_[j] + h_ * ((1 - gamma) * a_[j] + gamma * e_[j]) + kick;
    } else {  // a_1 as the forces' small difference would lose digits
      e_[j] = ((d_[j] / h_ - v_[j] - 0.5 * kick) / h_ - (0.5 - beta) * a_[j]) / beta;
      v_end_[j] = 2 / h_ * d_[j] - v_[j] - 0.5 * alpha * alpha * h_ * (e_[j] - a_[j]);
    }
  }
  BodyWork step;
  if (kicked_) step.contact = kick_.dot(d_) / h_;
  if (!loads_.empty()) step.external = 0.5 * d_.dot(f0_ + f1_);
  step.damping = -(c * d_.array().square()).sum() / h_;
  if (alpha != 0)
    step.numerical =
        flow_energy(eta_end_, v_end_) - before - step.contact - step.external - step.damping;
  work_.contact += step.contact;
  work_.external += step.external;
  work_.damping += step.damping;
  work_.numerical += step.numerical;
  a_.swap(e_);
  f0_.swap(f1_);
}

}  // namespace cbr
