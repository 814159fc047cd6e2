// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/static_state.hpp"

#include <utility>

#include "common/files/state_archive.hpp"

namespace cbr {

void StaticState::begin(const Vector& u) {
  u_start = u;
  for (Vector* force : {&loads, &contact, &friction, &loads_start, &contact_start, &friction_start})
    force->setZero(u.size());
}

void StaticState::begin_iteration(Vector loads_now) {
  loads = std::move(loads_now);
  contact.setZero();
  friction.setZero();
}

void StaticState::book(const Vector& u, BodyWork& work) {
  const Vector move = u - u_start;
  work.external += 0.5 * move.dot(loads_start + loads);
  work.contact += 0.5 * move.dot(contact_start + contact);
  work.friction += 0.5 * move.dot(friction_start + friction);
  u_start = u;
  loads_start = loads;
  contact_start = contact;
  friction_start = friction;
}

void StaticState::keep_state(StateArchive& archive) {
  archive(u_start, loads_start, contact_start, friction_start);
  if (archive.restores()) {
    loads = loads_start;
    contact = contact_start;
    friction = friction_start;
  }
}

}  // namespace cbr
