// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/static_state.hpp"

#include <utility>

#include "common/files/state_archive.hpp"

namespace cbr {

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
