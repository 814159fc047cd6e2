// SPDX-License-Identifier: GPL-3.0-or-later
// Forces of contact that last: the modes move under them, and impulses are what they change
// (docs/theory.md, "Forces that last").
#include "dynamics/motion/modal/superelement_body.hpp"

namespace cbr {

void SuperelementBody::ContactShare::add(const Vector& force, ImpulseKind kind) {
  if (empty()) {
    all.setZero(force.size());
    friction.setZero(force.size());
  }
  all += force;
  if (kind == ImpulseKind::friction) friction += force;
}

// What the forces do to the rates in a share of the step, as impulses.
Vector SuperelementBody::lasting_kick(double share, const Vector& force) const {
  if (force.size() == 0) return Vector::Zero(eta_.size());
  return share * contact_kick(h_, force);
}

void SuperelementBody::own_expect_forces(Index set, const Impulses& forces) {
  lasting_.next.clear();
  if (scheme() == Scheme::newmark) return;
  forces.each([&](const Points& f, ImpulseKind kind) {
    take_force(set, f);
    lasting_.next.add(f_, kind);
  });
  if (lasting_.ever || lasting_.next.empty()) return;
  lasting_.ever = true;
  regular_ = other_ = nullptr;  // without terms of forces
}

// From statics: forces of contact as they are.
void SuperelementBody::let_last(const Vector& contact, const Vector& friction) {
  lasting_.ever = true;
  regular_ = other_ = nullptr;
  lasting_.now.clear();
  lasting_.now.add(contact, ImpulseKind::contact);
  lasting_.now.add(friction, ImpulseKind::friction);
}

// The impulses of contact to come have the lasting forces in them, which act by themselves.
void SuperelementBody::kick_back() {
  if (lasting_.now.empty()) return;
  f_ = lasting_kick(-1, lasting_.now.all - lasting_.now.friction);
  feel_kick(ImpulseKind::contact);
  if (lasting_.now.friction.isZero(0)) return;
  f_ = lasting_kick(-1, lasting_.now.friction);
  feel_kick(ImpulseKind::friction);
}

// Of a kick that finds the rates v. Friction's is the work of its impulses along the ways of their
// nodes; contact's is all else that the kick brings. of_friction: or null.
void SuperelementBody::book_kick(const Vector& kick, const Vector* of_friction, const Vector& v) {
  double friction = 0;
  if (of_friction != nullptr)
    friction = energy_product(*of_friction, v) + 0.5 * energy_product(*of_friction, kick);
  work_.contact += kick.dot(v) + 0.5 * kick.squaredNorm() - friction;
  work_.friction += friction;
}

// Half of what forces change acts before the moment at which they do, and half after it.
void SuperelementBody::change_force() {
  if (lasting_.now.empty() && lasting_.next.empty()) return;
  const Vector kick = lasting_kick(0.5, lasting_.next.all) - lasting_kick(0.5, lasting_.now.all);
  const Vector friction =
      lasting_kick(0.5, lasting_.next.friction) - lasting_kick(0.5, lasting_.now.friction);
  book_kick(kick, &friction, v_end_);
  v_end_ += kick;
}

// Work of forces at the ends of steps, from the middle of the kick at the start of the step to that
// of the kick at its end, and what is left of that kick for the next step.
void SuperelementBody::accept_late() {
  const Vector start = 0.5 * late_.all, of_friction = 0.5 * late_.friction;
  book_kick(start, &of_friction, v_ - start);
  v_end_ -= late_end_.all;
  const Vector before = 0.5 * (late_end_.all - lasting_kick(1, lasting_.now.all)),
               friction_before =
                   0.5 * (late_end_.friction - lasting_kick(1, lasting_.now.friction));
  book_kick(before, &friction_before, v_end_);
  late_end_.all -= lasting_kick(1, lasting_.next.all);
  late_end_.friction -= lasting_kick(1, lasting_.next.friction);
  v_end_ += before + 0.5 * late_end_.all;
}

}  // namespace cbr
