// SPDX-License-Identifier: GPL-3.0-or-later
// Forces of contact that last: the modes move under them, and impulses are what they change
// (docs/theory.md, "Forces that last").
#include "dynamics/motion/modal/superelement_body.hpp"

namespace cbr {

// What the forces do to the rates in a share of the step, as impulses.
Vector SuperelementBody::lasting_kick(double share, const Vector& force) const {
  if (force.size() == 0) return Vector::Zero(eta_.size());
  return share * contact_kick(h_, force);
}

void SuperelementBody::own_expect_forces(Index set, const Points& forces) {
  lasting_.next.resize(0);
  if (scheme() == Scheme::newmark || frame_ || forces.rows() == 0) return;
  take_force(set, forces);
  lasting_.next = f_;
  if (lasting_.ever) return;
  lasting_.ever = true;
  regular_ = other_ = nullptr;  // without terms of forces
}

// From statics: forces of contact as they are.
void SuperelementBody::let_last(const Vector& force) {
  lasting_.ever = true;
  regular_ = other_ = nullptr;
  lasting_.now = force;
}

// The impulses of contact to come have the lasting forces in them, which act by themselves.
void SuperelementBody::kick_back() {
  if (lasting_.now.size() == 0) return;
  f_ = lasting_kick(-1, lasting_.now);
  feel_kick();
}

// Of a kick that finds the rates v.
void SuperelementBody::book_kick(const Vector& kick, const Vector& v) {
  work_.contact += kick.dot(v) + 0.5 * kick.squaredNorm();
}

// Half of what forces change acts before the moment at which they do, and half after it.
void SuperelementBody::change_force() {
  if (lasting_.now.size() == 0 && lasting_.next.size() == 0) return;
  const Vector kick = lasting_kick(0.5, lasting_.next) - lasting_kick(0.5, lasting_.now);
  book_kick(kick, v_end_);
  v_end_ += kick;
}

// Work of forces at the ends of steps, from the middle of the kick at the start of the step to that
// of the kick at its end, and what is left of that kick for the next step.
void SuperelementBody::accept_late() {
  const Vector start = 0.5 * late_;
  book_kick(start, v_ - start);
  v_end_ -= late_end_;
  const Vector before = 0.5 * (late_end_ - lasting_kick(1, lasting_.now));
  book_kick(before, v_end_);
  late_end_ -= lasting_kick(1, lasting_.next);
  v_end_ += before + 0.5 * late_end_;
}

}  // namespace cbr
