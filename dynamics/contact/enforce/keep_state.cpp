// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/keep_state.hpp"

namespace cbr {

void keep_state(StateArchive& archive, Box& box) { archive(box.lower, box.upper); }

void keep_state(StateArchive& archive, MotionBound& bound) {
  archive(bound.lower, bound.upper, bound.lower_speed, bound.upper_speed, bound.growth, bound.acceleration);
}

void keep_state(StateArchive& archive, ContactTerm& term) { archive(term.body, term.node, term.coefficient); }

void keep_state(StateArchive& archive, ContactPoint& point) {
  archive(point.frame, point.gap, point.start_gap, point.area, point.slot, point.face);
  archive(point.first_term, point.n_terms, point.n_slave_terms);
}

void keep_state(StateArchive& archive, ContactList& list) { archive(list.points, list.terms); }

void keep_state(StateArchive& archive, PointLaw& law) { archive(law.law, law.friction); }

void keep_state(StateArchive& archive, PointKey& key) { archive(key.slave, key.master, key.slot, key.node, key.ordinal, key.law); }

void keep_state(StateArchive& archive, GapResponse& W) { archive(W.is_sparse, W.dense, W.sparse); }

void keep_state(StateArchive& archive, PairMemory& memory) {
  archive(memory.face, memory.known_face, memory.further_faces, memory.offset, memory.impulse, memory.elastic_slip, memory.near);
  archive(memory.has_points, memory.adjust, memory.initial_overlap, memory.initial_gap, memory.depth, memory.drift_taken);
}

void keep_state(StateArchive& archive, PenaltyMemory& memory) { archive(memory.stiffness, memory.dashpot, memory.n_seen); }

void keep_state(StateArchive& archive, ImpulseMemory& memory) {
  archive(memory.rows, memory.laws, memory.h, memory.keys, memory.defects, memory.first_error, memory.extra);
  archive(memory.wait, memory.backoff, memory.n_formed, memory.n_changed, memory.n_steps, memory.n_pushes);
  bool has_solver = memory.solver.has_value();
  archive(has_solver);
  if (archive.restores()) {
    memory.solver.reset();
    if (has_solver) memory.solver.emplace(GapResponse(), std::vector<PointLaw>());
  }
  if (has_solver) memory.solver->keep_state(archive);
}

void keep_state(StateArchive& archive, ContactBody& body) {
  archive(body.start, body.end, body.impulses, body.friction, body.move, body.has_move, body.swept, body.longest_way);
  archive(body.still);
}

}  // namespace cbr
