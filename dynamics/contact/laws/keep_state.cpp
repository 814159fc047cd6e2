// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/laws/keep_state.hpp"

namespace cbr {

void keep_state(StateArchive& archive, Box& box) { archive(box.lower, box.upper); }

void keep_state(StateArchive& archive, MotionBound& bound) {
  archive(bound.lower, bound.upper, bound.lower_speed, bound.upper_speed, bound.growth,
          bound.acceleration);
}

void keep_state(StateArchive& archive, ContactTerm& term) {
  archive(term.body, term.node, term.coefficient);
}

void keep_state(StateArchive& archive, ContactPoint& point) {
  archive(point.frame, point.gap, point.start_gap, point.area, point.slot, point.face);
  archive(point.first_term, point.n_terms, point.n_slave_terms);
}

void keep_state(StateArchive& archive, ContactList& list) { archive(list.points, list.terms); }

void keep_state(StateArchive& archive, PointLaw& law) { archive(law.law, law.friction); }

void keep_state(StateArchive& archive, GapResponse& W) { archive(W.is_sparse, W.dense, W.sparse); }

static void keep_state(StateArchive& archive, StandingSearch& standing) {
  archive(standing.n_nodes, standing.n_both, standing.has);
  archive(standing.list, standing.distance, standing.separation, standing.has_all);
  archive(standing.extra, standing.slave_at, standing.master_at);
}

void keep_state(StateArchive& archive, EdgePair& edges) { archive(edges.slave, edges.master); }

void keep_state(StateArchive& archive, PairMemory& memory) {
  archive(memory.edges, memory.face, memory.known_face, memory.further_faces, memory.offset,
          memory.impulse, memory.begins_in_equilibrium, memory.cells.closed, memory.cells.whole,
          memory.cells.slots);
  for (Points& force : memory.forces) archive(force);
  archive(memory.velocity, memory.elastic_slip, memory.near);
  archive(memory.has_points, memory.adjust, memory.initial_overlap, memory.initial_gap,
          memory.depth, memory.drift_taken, memory.standing);
}

}  // namespace cbr
