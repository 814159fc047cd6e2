// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/laws/keep_state.hpp"

#include "dynamics/contact/enforce/enforcement.hpp"

namespace cbr {

void keep_state(StateArchive& archive, PointKey& key) {
  archive(key.slave, key.master, key.slot, key.node, key.ordinal, key.law);
}

void keep_state(StateArchive& archive, PenaltyMemory& memory) {
  archive(memory.stiffness, memory.dashpot, memory.n_seen);
}

void keep_state(StateArchive& archive, ImpulseMemory& memory) {
  archive(memory.rows, memory.laws, memory.h, memory.keys, memory.defects, memory.first_error,
          memory.extra);
  archive(memory.wait, memory.backoff, memory.n_formed, memory.n_changed, memory.n_steps,
          memory.n_pushes, memory.unknowns, memory.x, memory.N);
  bool has_solver = memory.solver.has_value();
  archive(has_solver);
  if (archive.restores()) {
    memory.standing.clear();  // formed again from the rest
    memory.solver.reset();
    if (has_solver) memory.solver.emplace(GapResponse(), std::vector<PointLaw>());
  }
  if (has_solver) memory.solver->keep_state(archive);
}

void keep_state(StateArchive& archive, ContactBody& body) {
  archive(body.start, body.end, body.impulses, body.friction, body.move, body.has_move, body.swept,
          body.longest_way);
  archive(body.still, body.lasting, body.rubbed_before);
}

}  // namespace cbr
