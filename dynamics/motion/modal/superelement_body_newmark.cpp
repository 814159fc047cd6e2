// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement under Newmark's method (HHT-alpha): its modes are uncoupled, so a step solves
// nothing.

#include <algorithm>
#include <cassert>

#include "dynamics/motion/modal/superelement_body.hpp"

namespace cbr {
namespace {

constexpr double stiff = 20;  // omega h of a mode whose rates are taken from its move

}  // namespace

// h / (1 + theta omega^2), and the move of a mode's end by a unit impulse: half of the former as a
// force over the step; all of it as a velocity more at the start, where with damping it also
// takes an acceleration from a_0.
const Vector& SuperelementBody::newmark_weight(double h) const {
  if (newmark_h_ != h || newmark_weight_.size() != form_->omega.size()) {
    newmark_weight_ = h / (1 + newmark_.stiffness_factor(h) *
                                   (form_->omega.array().square() + 2 / h * damping_.c.array()));
    newmark_kick_weight_ = (kicks_at_start(h) ? 1.0 : 0.5) * newmark_weight_;
    if (kicks_at_start(h)) {
      const double slowed = 2 * (1 + newmark_.alpha) * newmark_.beta() - 0.5;
      newmark_kick_weight_.array() *= 1 + h * slowed * damping_.c.array();
    }
    newmark_h_ = h;
    n_soft_ = std::upper_bound(form_->omega.begin(), form_->omega.end(), stiff / h) -
              form_->omega.begin();
  }
  return newmark_weight_;
}

// Of the move d = eta_1 - eta_0, which is kept by itself as it may be small beside both. Damping
// takes the rate at the end from the move, v_1 = 2 d / h - v_0, and so is a stiffness 2 c / h more
// and a force:
//   a_1 = e - (1 + alpha) (omega^2 + 2 c / h) d,
//   e = (1 + alpha) (f_1 + 2 c v_0) - alpha f_0 - omega^2 eta_0 - c v_0,
//   (1 + theta (omega^2 + 2 c / h)) d = h v_0 + h^2 ((1/2 - beta) a_0 + beta e).
void SuperelementBody::predict_newmark(double h) {
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

// Residual compliance follows forces at once and has no velocities: impulses of contact act at the
// start of a step, as with the other schemes, where it is no longer than the critical one.
bool SuperelementBody::kicks_at_start(double h) const {
  return form_->residual && highest_mode() * h <= 2;
}

const Vector& SuperelementBody::newmark_kick_weight(double h) const {
  newmark_weight(h);
  return newmark_kick_weight_;
}

void SuperelementBody::push_newmark(const Vector& kick) {
  d_.array() += newmark_kick_weight(h_).array() * kick.array();
  eta_end_ = eta_ + d_;
}

// A kick at the start changes the velocity that the step begins with; the rest is a step without.
void SuperelementBody::begin_with_kick() {
  if (!kicked_ || !kicks_at_start(h_)) return;
  book_kick(kick_, v_);
  v_ += kick_;
  kicked_ = false;
  a_.array() -= damping_.c.array() * kick_.array();
  e_.array() += (1 + 2 * newmark_.alpha) * damping_.c.array() * kick_.array();
}

// The rates of the end belong to the move that contact has left. With [.] the change over a step
// and the mean of both its ends, of the velocity and of any load, written with a bar,
//   [eta] = h vbar + h^2 (beta - gamma / 2) [a],   beta - gamma / 2 = alpha^2 / 4,
// and the energy changes by
//   contact: p . [eta] / h
//   loads:   [eta] . (fbar - k ([f] - [f]_before)),   k = alpha (1/2 + alpha)
//   scheme:  k omega^2 [eta] . ([eta] - [eta]_before) - alpha^2 h^2 / 4 (1/2 [a . a] - alpha [a] .
//   [a]) - alpha^2 h / 4 p . [a].
void SuperelementBody::accept_newmark() {
  if (is_damped()) return accept_newmark_damped();
  const auto omega2 = form_->omega.array().square();
  const double alpha = newmark_.alpha, quarter = 0.25 * alpha * alpha * h_,
               k = alpha * (0.5 + alpha);
  if (kicked_) work_.contact += kick_.dot(d_) / h_;
  e_.array() -= (1 + alpha) * omega2 * d_.array();  // a_1
  newmark_rates();
  if (!loads_.empty()) {
    work_.external += 0.5 * d_.dot(f0_ + f1_);
    if (alpha != 0) work_.external -= k * d_.dot(f1_ - f0_ - load_change_);
  }
  if (alpha != 0) {
    work_.numerical +=
        k * (omega2 * d_.array() * (d_ - move_).array()).sum() -
        quarter * h_ * (0.5 * (e_ - a_).dot(e_ + a_) - alpha * (e_ - a_).squaredNorm());
    if (kicked_) work_.numerical -= quarter * kick_.dot(e_ - a_);
    load_change_ = f1_ - f0_;
    move_.swap(d_);
  }
  a_.swap(e_);
  f0_.swap(f1_);
}

// With alpha = 0 the energy changes by the loads' and impulses' work along the move and by -c d^2 /
// h of each mode. With another alpha the rest is that of the scheme.
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

// v_1 of the move and of a_0, a_1 (in e). With alpha = 0 a step is a map (eta, v)_0 -> (eta, v)_1
// of determinant 1, which keeps the energy. Written with coefficients that are rounded it has to be
// so too, or else the energy grows or decays by some 1e-16 in every step: as three shears, each of
// which has determinant 1 whatever its coefficient. Up to omega h = 20 these are
//   v* = v_0 + h/2 a_0,   eta_1 = eta_0 + d(v*),   v_1 = v* + h/2 a_1,
// which at larger omega h takes v_1 as a small difference of large numbers; there the roles of eta
// and v are exchanged, nearly:
//   v_1 = 2/h d - v_0,   eta_1 = (f_0 + f_1 - 2/h (v_1 - v_0 - p)) / omega^2 - eta_0,   a_1 = f_1 -
//   omega^2 eta_1.
void SuperelementBody::newmark_rates() {
  const double alpha = newmark_.alpha, gamma = newmark_.gamma();
  const Index m = n_soft_, n = eta_.size() - n_soft_;
  v_end_.head(m) = v_.head(m) + h_ * ((1 - gamma) * a_.head(m) + gamma * e_.head(m));
  if (kicked_) v_end_.head(m) += kick_.head(m);
  if (n == 0) return;
  v_end_.tail(n) = (2 / h_) * d_.tail(n) - v_.tail(n);
  if (alpha != 0) {
    v_end_.tail(n) -= 0.5 * alpha * alpha * h_ * (e_.tail(n) - a_.tail(n));
    return;
  }
  f_.tail(n) = v_end_.tail(n) - v_.tail(n);
  if (kicked_) f_.tail(n) -= kick_.tail(n);
  const auto omega2 = form_->omega.tail(n).array().square();
  eta_end_.tail(n) =
      (f0_.tail(n) + f1_.tail(n) - (2 / h_) * f_.tail(n)).array() / omega2 - eta_.tail(n).array();
  e_.tail(n) = f1_.tail(n).array() - omega2 * eta_end_.tail(n).array();
}

void SuperelementBody::arrive_newmark() {
  if (!arrived_) {
    begin_with_kick();
    accept_newmark();
  }
  arrived_ = true;
}

void SuperelementBody::own_end_velocities(Index set, Points& v) {
  arrive_newmark();
  sets_[set].rows->displacements(v_end_, placement_.T, v);
}

NodeResponse SuperelementBody::own_velocity_response(Index set) const {
  return answer(set, {ResponseOf::Weight::velocity}, Vector::Ones(form_->omega.size()));
}

void SuperelementBody::own_add_end_impulses(Index set, const Points& impulses) {
  if (scheme() != Scheme::newmark) return add_late(set, impulses);
  arrive_newmark();
  sets_[set].rows->kick(impulses, placement_.T, local_, f_);
  book_kick(f_, v_end_);
  v_end_ += f_;
  a_.array() -= damping_.c.array() * f_.array();
}

}  // namespace cbr
