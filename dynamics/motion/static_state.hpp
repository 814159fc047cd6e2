// SPDX-License-Identifier: GPL-3.0-or-later
// What a body in equilibrium keeps of its load step.
#pragma once

#include "common/base/types.hpp"
#include "dynamics/motion/body.hpp"

namespace cbr {

class StateArchive;

// Generalised displacements u and forces of a body with n coordinates: at the end of the last load
// step, and in this one.
struct StaticState {
  Vector u_start;                     // n
  Vector loads, contact;              // n, of this iteration
  Vector loads_start, contact_start;  // n

  bool empty() const { return u_start.size() == 0; }
  void begin(const Vector& u);  // once: forces are 0
  // The forces of an iteration; those of contact come one by one.
  void begin_iteration(Vector loads_now);
  void add(const Vector& force) { contact += force; }
  // Work of the mean forces over the load step, u being its end: exact for a linear body. This load
  // step is the last one then.
  void book(const Vector& u, BodyWork& work);
  void keep_state(StateArchive& archive);
};

}  // namespace cbr
