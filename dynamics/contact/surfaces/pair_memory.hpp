// SPDX-License-Identifier: GPL-3.0-or-later
// What a pair of surfaces remembers of its slave nodes; node-face, mortar and walls share it.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"

namespace cbr {

// What candidates were found for: see kept_candidates.hpp. No answer depends on it.
struct KeptCandidates {
  bool is_known = false;
  double skin = 0;
  std::array<double, 3> margins{};  // of the slave's nodes, the master's, and edges
  int served = 0;                   // searches since
  Points slave_at, master_at;       // of the surfaces' nodes, at the end of the step
};

// Edges of slave and master.
struct EdgePair {
  Index slave = 0, master = 0;
  auto operator<=>(const EdgePair&) const = default;
};

// The points of a search that later steps may take over: standing_search.hpp.
struct StandingSearch {
  ContactList list;  // empty: none
  // The first so many points are of the slave's nodes, those behind the second number of edges
  std::size_t n_nodes = 0, n_both = 0;
  Vector gap;            // normal, of the points, at the search
  Points separation;     // of the points: sum of coefficient x position then, scene axes
  Vector offset;         // as in PairMemory, then
  bool has_all = false;  // every slave node has a point
  // Otherwise: how much nearer than the reach of a search its nodes may come, and where those of
  // both surfaces were
  double extra = 0;
  Points slave_at, master_at;
};

// What a pair remembers from step to step, per slave node (in the order of the slave surface's
// nodes), or per pair of edges.
struct PairMemory {
  std::vector<Index> face;        // master face it touched in the last step, or -1
  std::vector<Index> known_face;  // the one that it touched last since the bodies were apart, or -1
  // Further faces that it touched in the last step, so many places per node, -1 behind the last;
  // empty where no faces rise from others.
  static constexpr std::size_t n_further = 7;
  std::vector<Index> further_faces;
  // Distance that counts as closed: < 0: overlap that is left as it is; > 0: an initial gap that
  // was adjusted.
  Vector offset;
  Points impulse;  // of the last step, scene axes: where the solver starts from
  // Forces of the last step and of the one before, by slots, of ties by points; scene axes. Empty
  // before there were any
  Points force, force_before;
  bool begins_in_equilibrium = false;  // motion began with forces of statics, which had lasted
  Points elastic_slip;  // penalty with friction: tangential stretch of the springs, scene axes
  // mortar: slave and master face of each pair of faces that the last search found, ascending
  std::vector<Index> near;
  // Of edges: those of slave and master that each slot stands for, ascending.
  std::vector<EdgePair> edges;
  std::vector<Box> node_boxes, face_boxes;
  BroadPhase grid;
  std::vector<EdgePair> edge_candidates;
  KeptCandidates kept;  // node-face, for both sides' nodes and edges
  StandingSearch standing;
  // Given before each search: a length by which it reaches farther than one step asks for
  double extra_reach = 0;
  // Mortar: as faces slide, the weights of a point change and its gap with them. What impulses have
  // taken over such changes (impulse x length: energy x step) and may give back.
  double drift_taken = 0;
  bool has_points = false;  // in the last step
  // given before the first step: initial gaps and overlaps up to this length count as closed
  double adjust = 0;
  // Given before the first step: mortar's points found deeper than they were left count so at once:
  // springs push them out softly, ties join them where they are.
  bool lets_jump = false;
  double kept_share = 1;          // statics: of an overlap that is found, what is left as it is
  double initial_overlap = 0;     // largest depth found by the initial detection
  double initial_gap = HUGE_VAL;  // smallest gap from 0 that it found within reach
  // largest depth at the end of the last step: what is behind a face is still looked for
  double depth = 0;
};

// Sizes memory for n slave nodes at the first call.
void start_memory(Index n, PairMemory& memory);

// Gives slots to other pairs of edges, ascending: those that stay keep what is known of them.
void renumber(const std::vector<EdgePair>& edges, PairMemory& memory);

// Gaps up to this are looked at, for a side of face size `size` and a largest (relative) motion in
// this step: neighbours of a node in contact may be drawn in by its impulse, about as far as
// anything moves in the step.
double contact_reach(double size, double motion, bool initial, const PairMemory& memory);

// A slave node that has not touched before starts the step at this distance: overlaps are left as
// they are, and with `initial` gaps within `adjust` are closed; reported with `initial`.
void keep_overlap(Index slot, double distance, bool initial, PairMemory& memory);

// The bodies are apart: nothing touches, no overlap is left; an adjusted gap stays closed. Costs
// nothing when that is so already.
void forget(PairMemory& memory);

// After the step: who touches (impulse or closed gap), and overlaps that have opened; forget()
// without points. [first, last) are the points of this search; rows of `end_gap` and `impulse` (n x
// 3, in the points' frames) go with list.points. pushes: where contact acts, if not by impulses
// above 0 alone.
void remember(const ContactList& list, std::size_t first, std::size_t last, const Points& end_gap,
              const Points& impulse, double closed, PairMemory& memory,
              const std::function<bool(std::size_t point)>& pushes = {});

}  // namespace cbr
