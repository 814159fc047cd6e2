// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/modal_newmark.hpp"

#include <algorithm>
#include <utility>

namespace cbr {
namespace {

constexpr double stiff = 20;  // omega h of a mode whose rates are taken from its move

}  // namespace

ModalNewmark::ModalNewmark(const NewmarkOptions& numbers, std::shared_ptr<const ModalForm> form,
                           ModalRates damping)
    : form_(std::move(form)),
      damping_(std::move(damping)),
      scheme_(numbers, operators()),
      room_(form_->omega.size()) {}

NewmarkOperators ModalNewmark::operators() {
  const auto omega2 = [this] { return form_->omega.array().square(); };
  const auto damp = [this](const Vector& v, Vector& cv) { cv = damping_.c.cwiseProduct(v); };
  NewmarkOperators of;
  of.stiffness = [omega2](const Vector& eta, Vector& f) { f = omega2() * eta.array(); };
  of.stiffness_of_move = [omega2](const Vector& move, const Vector&, Vector& f) {
    f = omega2() * move.array();
  };
  if (damping_.hash != 0) of.damping = of.damping_of_move = damp;
  of.solve = [this](double h, Vector& f) {
    weigh(h);
    f.array() *= weight_.array();
  };
  of.solve_mass = [](Vector&) {};
  of.energy = [this](const Vector& eta, const Vector& v, bool) {
    return modal_energy(form_->omega, {eta, v});
  };
  of.correct = [this](const NewmarkStep& step) {
    damping_.hash == 0 ? correct(step) : correct_damped(step);
  };
  return of;
}

// h / (1 + theta omega^2), and the move of a mode's end by a unit impulse: half of the former as a
// force over the step; all of it as a velocity more at the start, where with damping it also
// takes an acceleration from a_0.
void ModalNewmark::weigh(double h) const {
  if (weighed_h_ == h) return;
  const Vector& omega = form_->omega;
  weight_ = h / (1 + stiffness_factor(h) * (omega.array().square() + 2 / h * damping_.c.array()));
  kick_weight_ = (kicks_at_start(h) ? 1.0 : 0.5) * weight_;
  if (kicks_at_start(h)) {
    const NewmarkOptions& numbers = scheme_.numbers();
    const double slowed = 2 * (1 + numbers.alpha) * numbers.beta() - 0.5;
    kick_weight_.array() *= 1 + h * slowed * damping_.c.array();
  }
  weighed_h_ = h;
  n_soft_ = std::upper_bound(omega.begin(), omega.end(), stiff / h) - omega.begin();
}

const Vector& ModalNewmark::kick_weight(double h) const {
  weigh(h);
  return kick_weight_;
}

void ModalNewmark::predict(double t, double h, const Loads<Vector>& loads, const ModalState& start,
                           ModalState& end) {
  h_ = h;
  scheme_.predict(t, h, loads, start.eta, start.v, end.eta);
}

void ModalNewmark::push(const Vector& kick, const ModalState& start, ModalState& end) {
  room_ = kick_weight(h_).cwiseProduct(kick);
  scheme_.push(room_, start.eta, end.eta);
}

// A kick at the start changes the velocity that the step begins with; the rest is a step without.
void ModalNewmark::arrive(const Loads<Vector>& loads, Kick& kick, ModalState& start,
                          ModalState& end, BodyWork& work) {
  if (scheme_.has_arrived()) return;
  if (kick && kicks_at_start(h_)) {
    book_kick(kick.sum(), start.v, work);
    start.v += kick.sum();
    scheme_.feel_start(kick.sum());
    kick.clear();
  }
  scheme_.arrive(!loads.empty(), kick, start.eta, start.v, end.eta, end.v, work);
}

// With alpha = 0 a step is a map (eta, v)_0 -> (eta, v)_1 of determinant 1, which keeps the energy.
// Written with coefficients that are rounded it has to be so too, or else the energy grows or
// decays by some 1e-16 in every step: as three shears, each of which has determinant 1 whatever its
// coefficient. Up to omega h = 20 these are
//   v* = v_0 + h/2 a_0,   eta_1 = eta_0 + d(v*),   v_1 = v* + h/2 a_1,
// which at larger omega h takes v_1 as a small difference of large numbers; there the roles of eta
// and v are exchanged, nearly:
//   v_1 = 2/h d - v_0,   eta_1 = (f_0 + f_1 - 2/h (v_1 - v_0 - p)) / omega^2 - eta_0,   a_1 = f_1 -
//   omega^2 eta_1.
void ModalNewmark::correct(const NewmarkStep& step) {
  const double alpha = scheme_.numbers().alpha, h = step.h;
  const Index n = step.move.size() - n_soft_;
  if (n == 0) return;
  auto v_end = step.p_end.tail(n);
  v_end = (2 / h) * step.move.tail(n) - step.p.tail(n);
  if (alpha != 0) {
    v_end -= 0.5 * alpha * alpha * h * (step.Ma_end.tail(n) - step.Ma.tail(n));
    return;
  }
  auto change = room_.tail(n);
  change = v_end - step.p.tail(n);
  if (step.kick) change -= step.kick.sum().tail(n);
  const auto omega2 = form_->omega.tail(n).array().square();
  step.u_end.tail(n) = (step.f0.tail(n) + step.f1.tail(n) - (2 / h) * change).array() / omega2 -
                       step.u.tail(n).array();
  step.Ma_end.tail(n) = step.f1.tail(n).array() - omega2 * step.u_end.tail(n).array();
}

// a_1 as the forces' small difference would lose digits.
void ModalNewmark::correct_damped(const NewmarkStep& step) {
  const double alpha = scheme_.numbers().alpha, beta = scheme_.numbers().beta(), h = step.h;
  for (Index j = 0; j < step.move.size(); ++j) {
    if (weight_[j] > 0.01 * h) continue;
    const double rate = step.move[j] / h, kick = step.kick ? step.kick.sum()[j] : 0;
    step.Ma_end[j] = ((rate - step.p[j] - 0.5 * kick) / h - (0.5 - beta) * step.Ma[j]) / beta;
    step.p_end[j] = 2 * rate - step.p[j] - 0.5 * alpha * alpha * h * (step.Ma_end[j] - step.Ma[j]);
  }
}

void ModalNewmark::push_end(const Vector& kick, ModalState& end, BodyWork& work) {
  book_kick(kick, end.v, work);
  end.v += kick;
  scheme_.feel_end(kick);
}

}  // namespace cbr
