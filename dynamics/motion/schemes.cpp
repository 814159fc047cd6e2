// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/schemes.hpp"

#include <utility>

#include "common/files/state_archive.hpp"

namespace cbr {

// Of the move d = u_1 - u_0, which is kept by itself as it may be small beside both: stiff
// coordinates lose no digits. Damping takes the rate at the end from the move, v_1 = 2 d / h - v_0,
// and so is a stiffness 2 C / h more and a force:
//   M a_1 = e - (1 + alpha) (K + 2 C / h) d,
//   e = (1 + alpha) (f_1 + 2 C v_0) - alpha f_0 - K u_0 - C v_0,
//   A d = h p_0 + h^2 ((1/2 - beta) M a_0 + beta e).
void Newmark::predict(double t, double h, const Loads<Vector>& loads, const Vector& u,
                      const Vector& p, Vector& u_end) {
  const double alpha = numbers_.alpha, beta = numbers_.beta();
  h_ = h;
  for (Vector* f : {&f0_, &f1_}) f->resize(u.size());
  of_.stiffness(u, Ku_);
  if (of_.damping) of_.damping(p, Cv_);
  if (!started_) {
    loads.sum(t, f0_);
    Ma_ = f0_ - Ku_;
    if (of_.damping) Ma_ -= Cv_;
    for (Vector* x : {&last_move_, &last_change_of_f_}) x->setZero(u.size());
    started_ = true;
  }
  loads.sum(t + h, f1_);
  e_ = (1 + alpha) * f1_ - alpha * f0_ - Ku_;
  if (of_.damping) e_ += (1 + 2 * alpha) * Cv_;
  move_ = p + h * ((0.5 - beta) * Ma_ + beta * e_);
  of_.solve(h, move_);
  u_end = u + move_;
}

void Newmark::push(const Vector& move, const Vector& u, Vector& u_end) {
  move_ += move;
  u_end = u + move_;
}

void Newmark::feel_start(const Vector& impulse) {
  if (!of_.damping) return;
  of_.damping(impulse, Cv_);
  Ma_ -= Cv_;
  e_ += (1 + 2 * numbers_.alpha) * Cv_;
}

void Newmark::feel_end(const Vector& impulse) {
  if (!of_.damping) return;
  of_.damping(impulse, Cv_);
  Ma_ -= Cv_;
}

// p_1 = p_0 + h ((1 - gamma) M a_0 + gamma M a_1) + the impulses, which are no part of a.
void Newmark::arrive(bool loaded, const Kick& kick, const Vector& u, const Vector& p, Vector& u_end,
                     Vector& p_end, BodyWork& work) {
  const double alpha = numbers_.alpha, gamma = numbers_.gamma();
  arrived_ = true;
  const double energy = of_.damping && alpha != 0 ? of_.energy(u, p, false) : 0;
  of_.stiffness_of_move(move_, u_end, Ku_);
  e_ -= (1 + alpha) * Ku_;
  if (of_.damping) {
    of_.damping_of_move(move_, Cv_);
    e_ -= (1 + alpha) * 2 / h_ * Cv_;
  }
  p_end = p + h_ * ((1 - gamma) * Ma_ + gamma * e_);
  if (kick) p_end += kick.sum();
  const NewmarkStep step{h_, u, p, move_, Ma_, f0_, f1_, kick, u_end, p_end, e_};
  if (of_.correct) of_.correct(step);
  if (kick) work.contact += kick.sum().dot(move_) / h_;
  if (of_.damping) {
    book_damped(loaded, step, energy, work);
  } else {
    book(loaded, step, work);
  }
  Ma_.swap(e_);
  f0_.swap(f1_);
}

// With [.] the change over a step and the mean of both its ends, of the velocity and of any load,
// written with a bar,
//   [u] = h vbar + h^2 (beta - gamma / 2) [a],   beta - gamma / 2 = alpha^2 / 4,
// and the energy changes by
//   contact: p . [u] / h
//   loads:   [u] . (fbar - k ([f] - [f]_before)),   k = alpha (1/2 + alpha)
//   scheme:  k K [u] . ([u] - [u]_before) - alpha^2 h^2 / 4 (1/2 [a . M a] - alpha [a] . M [a]) -
//   alpha^2 h / 4 p . [a].
void Newmark::book(bool loaded, const NewmarkStep& step, BodyWork& work) {
  const double alpha = numbers_.alpha, quarter = 0.25 * alpha * alpha * h_,
               k = alpha * (0.5 + alpha);
  if (loaded) work.external += 0.5 * move_.dot(f0_ + f1_);
  if (alpha == 0) return;
  if (loaded) work.external -= k * move_.dot(f1_ - f0_ - last_change_of_f_);
  const double of_move = k * Ku_.dot(move_ - last_move_);
  Vector &change = Cv_, &a = Ku_;  // which have served: M [a] and [a]
  change = e_ - Ma_;
  a = change;
  of_.solve_mass(a);
  work.numerical += of_move - quarter * h_ * (0.5 * a.dot(e_ + Ma_) - alpha * a.dot(change));
  if (step.kick) work.numerical -= quarter * step.kick.sum().dot(a);
  last_change_of_f_ = f1_ - f0_;
  last_move_ = move_;
}

// With alpha = 0 the energy changes by the loads' and impulses' work along the move and by -d . C d
// / h. With another alpha the rest is that of the scheme.
void Newmark::book_damped(bool loaded, const NewmarkStep& step, double energy, BodyWork& work) {
  const double contact = step.kick ? step.kick.sum().dot(move_) / h_ : 0,
               external = loaded ? 0.5 * move_.dot(f0_ + f1_) : 0, damping = -move_.dot(Cv_) / h_;
  work.external += external;
  work.damping += damping;
  if (numbers_.alpha != 0)
    work.numerical +=
        of_.energy(step.u_end, step.p_end, true) - energy - contact - external - damping;
}

// The end of a step gives the next one its accelerations and loads; HHT-alpha looks back one step
// more.
void Newmark::keep_state(StateArchive& archive) {
  archive(started_, arrived_, Ma_, f0_, last_move_, last_change_of_f_);
}

void StaticState::begin(const Vector& u) {
  u_start = u;
  for (Vector* force : {&loads, &contact, &loads_start, &contact_start}) force->setZero(u.size());
}

void StaticState::begin_iteration(Vector loads_now) {
  loads = std::move(loads_now);
  contact.setZero();
}

void StaticState::book(const Vector& u, BodyWork& work) {
  const Vector move = u - u_start;
  work.external += 0.5 * move.dot(loads_start + loads);
  work.contact += 0.5 * move.dot(contact_start + contact);
  u_start = u;
  loads_start = loads;
  contact_start = contact;
}

void StaticState::keep_state(StateArchive& archive) {
  archive(u_start, loads_start, contact_start);
  if (archive.restores()) {
    loads = loads_start;
    contact = contact_start;
  }
}

}  // namespace cbr
