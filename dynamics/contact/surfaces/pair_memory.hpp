// SPDX-License-Identifier: GPL-3.0-or-later
// State of a pair of surfaces, per slave node; shared by node-face, mortar and walls.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"

namespace cbr {

// Positions and margins of the last search for candidates: kept_candidates.hpp. Results do not
// depend on them.
struct KeptCandidates {
  bool is_known = false;
  double skin = 0;
  std::array<double, 3> margins{};  // of the slave's nodes, the master's, and edges
  int served = 0;                   // reuses since the search
  Points slave_at, master_at;       // positions of the surfaces' nodes at the end of that step
};

// An edge of the slave and one of the master.
struct EdgePair {
  Index slave = 0, master = 0;
  auto operator<=>(const EdgePair&) const = default;
};

// Points of a search for reuse in later steps: standing_search.hpp.
struct StandingSearch {
  ContactList list;  // empty: none
  // Numbers of leading points: of the slave's nodes; of both sides' nodes. Those of edges follow
  std::size_t n_nodes = 0, n_both = 0;
  Vector distance;        // of each point along its normal at the search: overlaps may open since
  Points separation;      // of each point: sum of coefficient x position at the search, scene axes
  bool has_all = false;   // every slave node has a point
  std::vector<char> has;  // of a wall, which needs no more: whether each slave node has a point
  // Otherwise: extra reach of the search, which nodes may use up, and positions of both surfaces'
  // nodes then
  double extra = 0;
  Points slave_at, master_at;
};

// Unknowns of contact on the cells of the slave's pressure functions.
struct ChosenCells {
  std::vector<char> closed;  // whether each cell has its function; empty: nodes are the unknowns
  bool whole = false;        // functions are not truncated
  std::vector<Index> slots;  // with whole functions: the nodes that are unknowns too
};

// State of a pair from step to step, per slave node (in the order of the slave surface's nodes) or
// per pair of edges.
struct PairMemory {
  std::vector<Index> face;        // master face touched in the last step, or -1
  std::vector<Index> known_face;  // last touched face since the bodies were apart, or -1
  // Further faces touched in the last step, n_further per node, -1 after the last; empty without
  // rising faces.
  static constexpr std::size_t n_further = 7;
  std::vector<Index> further_faces;
  // Distance that counts as closed. < rest: a tolerated overlap; > rest: an adjusted initial gap.
  Vector offset;
  // Offset of other nodes. > 0: interference; < 0: clearance. Set as `adjust`. Before: at the start
  // of a load step, which may increase it
  double rest = 0, rest_before = 0;
  // Of a slot: distance from which gaps count, but for tolerated overlaps
  double lift(Index slot) const { return std::max(std::min(0.0, rest), offset[slot]); }
  Points impulse;  // of the last step, scene axes: the solver's starting point
  // Forces of the last four steps, latest first, by slot, of ties by point; scene axes. Empty at
  // first
  std::array<Points, 4> forces;
  bool begins_in_equilibrium = false;  // the run began with static forces, assumed constant before
  ChosenCells cells;                   // of load steps, and of motion after them
  // Where friction depends on the slip speed, and after load steps: relative velocities in the last
  // step, by slots, scene axes; infinite where there was no point, 0 at rest
  Points velocity;
  Points elastic_slip;  // penalty with friction: tangential extension of the springs, scene axes
  // mortar: slave and master face of each pair of faces found by the last search, ascending
  std::vector<Index> near;
  // For edges: the slave and master edge of each slot, ascending.
  std::vector<EdgePair> edges;
  std::vector<Box> node_boxes, face_boxes;
  BroadPhase grid;
  std::vector<EdgePair> edge_candidates;
  KeptCandidates kept;  // node-face: of both sides' nodes and edges
  StandingSearch standing;
  // Set before each search: reach beyond that of one step
  double extra_reach = 0;
  // Mortar: gaps change with the weights of the points while faces slide. Work that impulses have
  // taken by such changes (impulse x length: energy x step) and may return.
  double drift_taken = 0;
  bool has_points = false;  // in the last step
  // set before the first step: initial gaps and overlaps up to this length count as closed
  double adjust = 0;
  // Set before the first step: penetrations of mortar points by changed weights count at once.
  // Springs correct them smoothly, ties join points where they are.
  bool lets_jump = false;
  double kept_share = 1;          // statics: fraction of an overlap that is tolerated
  double initial_overlap = 0;     // largest penetration at the initial detection
  double initial_gap = HUGE_VAL;  // smallest gap >= 0 within reach then
  // largest penetration at the end of the last step: the search must cover it
  double depth = 0;
};

// Sizes `memory` for n slave nodes at the first call.
void start_memory(Index n, PairMemory& memory);

// Assigns slots to the pairs of edges, ascending. Pairs that remain keep their state.
void renumber(const std::vector<EdgePair>& edges, PairMemory& memory);

// Largest gap of interest, for faces of size `size` and the largest (relative) motion in this step.
// Impulses may draw in neighbours of a touching node by about that motion.
double contact_reach(double size, double motion, bool initial, const PairMemory& memory);

// Sets the offset of a slave node without contact that starts the step at this distance from the
// surface. Overlaps are tolerated. With `initial`, gaps within `adjust` count as closed and the
// extremes are recorded.
void keep_overlap(Index slot, double from_surface, bool initial, PairMemory& memory);

// Resets contact when the bodies are apart: no node touches, no overlap remains, adjusted gaps stay
// closed. Free if nothing touched before.
void forget(PairMemory& memory);

// Steps without a search, as no impulses were possible.
void pass_without_force(Index n_steps, PairMemory& memory);

// Updates the state after the step: touching nodes (impulse or closed gap), and overlaps that have
// opened; forget() without points. [first, last): points of this search. Rows of `end_gap` and
// `impulse` (n x 3, in the points' frames) correspond to list.points. pushes: whether contact acts
// at a point; default: an impulse above 0.
void remember(const ContactList& list, std::size_t first, std::size_t last, const Points& end_gap,
              const Points& impulse, double closed, PairMemory& memory,
              const std::function<bool(std::size_t point)>& pushes = {});

}  // namespace cbr
