// SPDX-License-Identifier: GPL-3.0-or-later
// A coupled body with Rayleigh's damping, C = alpha M + beta K.
#include "dynamics/motion/coupled/coupled_body.hpp"

namespace cbr {

// f = alpha p + beta K v, p = M v, on the free directions.
void CoupledBody::damping_force(const Vector& p, const Vector& v, Vector& f) const {
  if (damping_.beta == 0) {
    f = damping_.alpha * p;
    return;
  }
  f.resize(v.size());
  system_->multiply_stiffness(v, f);
  system_->drop_held(f);
  f = damping_.alpha * p + damping_.beta * f;
}

// The mean of v- and v+ (v_now_) times the damping's impulse. p_end_ does not have the kicks yet.
void CoupledBody::book_central_damping() {
  const double alpha = damping_.alpha;
  const Vector p_end = kicked_ ? Vector(p_end_ + kick_ / mass_factor(h_)) : p_end_;
  work_.damping -=
      0.5 * alpha * v_now_.dot(last_h_ * p_ + h_ * p_end) + 0.5 * (last_h_ + h_) * v_now_.dot(Cv_);
}

// M a_1 = (1 + alpha) (f_1 - K u_1 - C (2 d / h - v_0)) - alpha (f_0 - K u_0 - C v_0). Damping
// takes d . C d / h; with another alpha than 0 what is left of the change of energy is the scheme's
// own.
void CoupledBody::accept_newmark_damped() {
  const double alpha = newmark_.alpha, gamma = newmark_.gamma();
  BodyWork step;
  const BodyWork before_step = work_;
  const double before = 0.5 * (p_.dot(v_) + u_.dot(stiffness_force()));
  if (kicked_) {
    v_now_ = move_ / h_;
    book_kicks(v_now_);
    p_ += kick_;
  }
  const Vector F0 = f0_ - stiffness_force() - Cv_;
  u_.swap(u_end_);
  Ku_is_current_ = false;
  // C d
  Vector& Cd = work_vector_;
  system_->multiply_mass(move_, damping_room_);
  system_->drop_held(damping_room_);
  damping_force(Vector(damping_room_), move_, Cd);
  step.damping = -move_.dot(Cd) / h_;
  if (!loads_.empty()) step.external = 0.5 * move_.dot(f0_ + f1_);
  p_ += h_ * (1 - gamma) * Ma_;
  F_ = Cv_ - 2 / h_ * Cd - stiffness_force();
  if (!loads_.empty()) F_ += f1_;
  Ma_ = (1 + alpha) * F_ - alpha * F0;
  system_->drop_held(Ma_);
  p_ += h_ * gamma * Ma_;
  v_ = p_;
  system_->factor(0).solve(v_);
  damping_force(p_, v_, Cv_);
  work_.damping += step.damping;
  work_.external += step.external;
  if (alpha != 0) {
    const double contact = work_.contact - before_step.contact;
    const double after = 0.5 * (p_.dot(v_) + u_.dot(stiffness_force()));
    work_.numerical += after - before - contact - step.external - step.damping;
  }
  if (!loads_.empty()) f0_.swap(f1_);
}

}  // namespace cbr
