// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/laws/keep_state.hpp"

#include "dynamics/contact/enforce/enforcement.hpp"

namespace cbr {

void keep_state(StateArchive& archive, PenaltyMemory& memory) {
  archive(memory.stiffness, memory.dashpot, memory.n_seen, memory.most_stiffness);
}

void keep_state(StateArchive& archive, ImpulseMemory& memory) {
  archive(memory.rows, memory.laws, memory.h, memory.n_formed, memory.unknowns, memory.x);
  archive(memory.rotates, memory.axes);
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
