// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement under Newmark's method (HHT-alpha): its modes are uncoupled, so a step solves
// nothing.

#include <algorithm>
#include <cassert>

#include "dynamics/motion/modal/modal_body.hpp"

namespace cbr {
namespace {

constexpr double stiff = 20;  // omega h of a mode whose rates are taken from its move

}  // namespace

// h / (1 + theta omega^2), and the move of a mode's end by a unit impulse: half of the former as a
// force over the step; all of it as a velocity more at the start, where with damping it also
// takes an acceleration from a_0.
void ModalNewmark::weigh(double h) const {
  if (weighed_h_ == h) return;
  const Vector& omega = form_->omega;
  weight_ = h / (1 + numbers_.stiffness_factor(h) *
                         (omega.array().square() + 2 / h * damping_.c.array()));
  kick_weight_ = (kicks_at_start(h) ? 1.0 : 0.5) * weight_;
  if (kicks_at_start(h)) {
    const double slowed = 2 * (1 + numbers_.alpha) * numbers_.beta() - 0.5;
    kick_weight_.array() *= 1 + h * slowed * damping_.c.array();
  }
  weighed_h_ = h;
  n_soft_ = std::upper_bound(omega.begin(), omega.end(), stiff / h) - omega.begin();
}

// Of the move d = eta_1 - eta_0, which is kept by itself as it may be small beside both. Damping
// takes the rate at the end from the move, v_1 = 2 d / h - v_0, and so is a stiffness 2 c / h more
// and a force:
//   a_1 = e - (1 + alpha) (omega^2 + 2 c / h) d,
//   e = (1 + alpha) (f_1 + 2 c v_0) - alpha f_0 - omega^2 eta_0 - c v_0,
//   (1 + theta (omega^2 + 2 c / h)) d = h v_0 + h^2 ((1/2 - beta) a_0 + beta e).
void ModalNewmark::predict(double t, double h, const Loads<Vector>& loads, const ModalState& start,
                           ModalState& end) {
  const auto omega2 = form_->omega.array().square();
  const auto c = damping_.c.array();
  const double alpha = numbers_.alpha, beta = numbers_.beta();
  h_ = h;
  for (Vector* f : {&f0_, &f1_, &change_}) f->resize(start.eta.size());
  if (!started_) {
    loads.sum(t, f0_);
    a_ = f0_.array() - omega2 * start.eta.array() - c * start.v.array();
    move_.setZero(start.eta.size());
    load_change_.setZero(start.eta.size());
    started_ = true;
  }
  loads.sum(t + h, f1_);
  e_ = (1 + alpha) * f1_.array() - alpha * f0_.array() - omega2 * start.eta.array() +
       (1 + 2 * alpha) * c * start.v.array();
  weigh(h);
  d_ = weight_.array() * (start.v + h * ((0.5 - beta) * a_ + beta * e_)).array();
  end.eta = start.eta + d_;
}

void ModalNewmark::push(const Vector& kick, const ModalState& start, ModalState& end) {
  d_.array() += kick_weight(h_).array() * kick.array();
  end.eta = start.eta + d_;
}

// A kick at the start changes the velocity that the step begins with; the rest is a step without.
void ModalNewmark::arrive(const Loads<Vector>& loads, Kick& kick, ModalState& start,
                          ModalState& end, BodyWork& work) {
  if (arrived_) return;
  arrived_ = true;
  if (kick && kicks_at_start(h_)) {
    book_kick(kick.sum(), start.v, work);
    start.v += kick.sum();
    a_.array() -= damping_.c.array() * kick.sum().array();
    e_.array() += (1 + 2 * numbers_.alpha) * damping_.c.array() * kick.sum().array();
    kick.clear();
  }
  if (damping_.hash == 0) {
    settle(!loads.empty(), kick, start, end, work);
  } else {
    settle_damped(!loads.empty(), kick, start, end, work);
  }
  a_.swap(e_);
  f0_.swap(f1_);
}

// The rates of the end belong to the move that contact has left. With [.] the change over a step
// and the mean of both its ends, of the velocity and of any load, written with a bar,
//   [eta] = h vbar + h^2 (beta - gamma / 2) [a],   beta - gamma / 2 = alpha^2 / 4,
// and the energy changes by
//   contact: p . [eta] / h
//   loads:   [eta] . (fbar - k ([f] - [f]_before)),   k = alpha (1/2 + alpha)
//   scheme:  k omega^2 [eta] . ([eta] - [eta]_before) - alpha^2 h^2 / 4 (1/2 [a . a] - alpha [a] .
//   [a]) - alpha^2 h / 4 p . [a].
void ModalNewmark::settle(bool loaded, const Kick& kick, const ModalState& start, ModalState& end,
                          BodyWork& work) {
  const auto omega2 = form_->omega.array().square();
  const double alpha = numbers_.alpha, quarter = 0.25 * alpha * alpha * h_,
               k = alpha * (0.5 + alpha);
  if (kick) work.contact += kick.sum().dot(d_) / h_;
  e_.array() -= (1 + alpha) * omega2 * d_.array();  // a_1
  find_rates(kick, start, end);
  if (loaded) {
    work.external += 0.5 * d_.dot(f0_ + f1_);
    if (alpha != 0) work.external -= k * d_.dot(f1_ - f0_ - load_change_);
  }
  if (alpha == 0) return;
  work.numerical += k * (omega2 * d_.array() * (d_ - move_).array()).sum() -
                    quarter * h_ * (0.5 * (e_ - a_).dot(e_ + a_) - alpha * (e_ - a_).squaredNorm());
  if (kick) work.numerical -= quarter * kick.sum().dot(e_ - a_);
  load_change_ = f1_ - f0_;
  move_.swap(d_);
}

// With alpha = 0 the energy changes by the loads' and impulses' work along the move and by -c d^2 /
// h of each mode. With another alpha the rest is that of the scheme.
void ModalNewmark::settle_damped(bool loaded, const Kick& kick, const ModalState& start,
                                 ModalState& end, BodyWork& work) {
  const auto omega2 = form_->omega.array().square();
  const auto c = damping_.c.array();
  const double alpha = numbers_.alpha, beta = numbers_.beta(), gamma = numbers_.gamma();
  const double before = modal_energy(form_->omega, start);
  e_.array() -= (1 + alpha) * (omega2 + 2 / h_ * c) * d_.array();  // a_1
  for (Index j = 0; j < d_.size(); ++j) {
    const double p = kick ? kick.sum()[j] : 0;
    if (weight_[j] > 0.01 * h_) {
      end.v[j] = start.v[j] + h_ * ((1 - gamma) * a_[j] + gamma * e_[j]) + p;
    } else {  // a_1 as the forces' small difference would lose digits
      e_[j] = ((d_[j] / h_ - start.v[j] - 0.5 * p) / h_ - (0.5 - beta) * a_[j]) / beta;
      end.v[j] = 2 / h_ * d_[j] - start.v[j] - 0.5 * alpha * alpha * h_ * (e_[j] - a_[j]);
    }
  }
  BodyWork step;
  if (kick) step.contact = kick.sum().dot(d_) / h_;
  if (loaded) step.external = 0.5 * d_.dot(f0_ + f1_);
  step.damping = -(c * d_.array().square()).sum() / h_;
  if (alpha != 0)
    step.numerical =
        modal_energy(form_->omega, end) - before - step.contact - step.external - step.damping;
  work += step;
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
void ModalNewmark::find_rates(const Kick& kick, const ModalState& start, ModalState& end) {
  const double alpha = numbers_.alpha, gamma = numbers_.gamma();
  const Index m = n_soft_, n = d_.size() - n_soft_;
  end.v.head(m) = start.v.head(m) + h_ * ((1 - gamma) * a_.head(m) + gamma * e_.head(m));
  if (kick) end.v.head(m) += kick.sum().head(m);
  if (n == 0) return;
  end.v.tail(n) = (2 / h_) * d_.tail(n) - start.v.tail(n);
  if (alpha != 0) {
    end.v.tail(n) -= 0.5 * alpha * alpha * h_ * (e_.tail(n) - a_.tail(n));
    return;
  }
  change_.tail(n) = end.v.tail(n) - start.v.tail(n);
  if (kick) change_.tail(n) -= kick.sum().tail(n);
  const auto omega2 = form_->omega.tail(n).array().square();
  end.eta.tail(n) = (f0_.tail(n) + f1_.tail(n) - (2 / h_) * change_.tail(n)).array() / omega2 -
                    start.eta.tail(n).array();
  e_.tail(n) = f1_.tail(n).array() - omega2 * end.eta.tail(n).array();
}

void ModalNewmark::push_end(const Vector& kick, ModalState& end, BodyWork& work) {
  book_kick(kick, end.v, work);
  end.v += kick;
  a_.array() -= damping_.c.array() * kick.array();
}

// The end of a step gives the next one its accelerations and loads; HHT-alpha looks back one step
// more.
void ModalNewmark::keep_state(StateArchive& archive) {
  archive(started_, arrived_, a_, f0_, move_, load_change_);
}

}  // namespace cbr
