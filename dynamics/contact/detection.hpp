// SPDX-License-Identifier: GPL-3.0-or-later
// Which slave nodes can touch which master faces in a step.
#pragma once

#include <cmath>
#include <vector>

#include "dynamics/contact/broad_phase.hpp"
#include "dynamics/contact/contact_point.hpp"
#include "dynamics/contact/contact_surface.hpp"

namespace cbr {

// Lengths as shares of the master face's size.
struct DetectionOptions {
  // A node this far off a face still counts as over it: matching surfaces whose edges coincide stay in contact at their edges
  // although they slip a little (2 % of a face at the rim of the paper's blocks, which are strained by 7 %).
  double edge_tolerance = 0.05;
  // The same for a node that has not touched a face that looks this way since the bodies were apart: it is to pass by.
  double new_edge_tolerance = 1e-3;
  // A node that was not in contact may start a step this deep and still be caught; deeper, it is on the other side of a thin body.
  double late_depth = 0.05;
  // A node that starts less deep than this behind a face may be just beside it, within the edge tolerances.
  double kept_depth = 1e-3;

  // How far beyond a face's box the nodes may be that count as over it, as a share of the box: its corners moved off a triangle's centre
  // of area by 3, of a quad's by 2 edge tolerances; what is twisted by its square.
  double overhang() const { return 2 * edge_tolerance * (1 + edge_tolerance); }
};

// What a pair remembers from step to step, per slave node (in the order of the slave surface's nodes).
struct PairMemory {
  std::vector<Index> face;        // master face it touched in the last step, or -1
  std::vector<Index> known_face;  // the one that it touched last since the bodies were apart, or -1
  // Distance that counts as closed: < 0: overlap that is left as it is; > 0: an initial gap that was adjusted.
  Vector offset;
  Points impulse;       // of the last step, scene axes: where the solver starts from
  Points elastic_slip;  // penalty with friction: tangential stretch of the springs, scene axes
  std::vector<Index> near;  // mortar: slave and master face of each pair of faces that the last search found, ascending
  std::vector<Box> node_boxes, face_boxes;
  BroadPhase grid;
  bool has_points = false;        // in the last step
  double adjust = 0;              // given before the first step: initial gaps and overlaps up to this length count as closed
  double initial_overlap = 0;     // largest depth found by the initial detection
  double initial_gap = HUGE_VAL;  // smallest gap from 0 that it found within reach
  double depth = 0;               // largest depth at the end of the last step: what is behind a face is still looked for
};

// Appends the contact points of a pair; slips are left 0. Positions are those of the bodies' start and predicted end; the path of a
// node relative to a face tells on which side it comes from, so that neither a large step nor a thin body lets it through. Further
// faces of a node are added when their normals differ by more than 45 degrees (a corner). `initial`: first step of the run: nodes
// may overlap by up to a face's size and keep that overlap.
void detect(const ContactSurface& slave, const ContactBody& slave_body, const ContactSurface& master,
            const ContactBody& master_body, bool initial, const DetectionOptions& options, PairMemory& memory, ContactList& list);

// Pieces that node-face, mortar and walls share. Sizes memory for n slave nodes at the first call.
void start_memory(Index n, PairMemory& memory);

// Gaps up to this are looked at, for a side of face size `size` and a largest (relative) motion in this step: neighbours of a node
// in contact may be drawn in by its impulse, about as far as anything moves in the step.
double contact_reach(double size, double motion, bool initial, const PairMemory& memory);

// A slave node that has not touched before starts the step at this distance: overlaps are left as they are, and with `initial` gaps
// within `adjust` are closed; reported with `initial`.
void keep_overlap(Index slot, double distance, bool initial, PairMemory& memory);

// Cosine between normals above which they hold a node in the same direction.
constexpr double same_side = 0.7;

// The bodies are apart: nothing touches, no overlap is left; an adjusted gap stays closed. Costs nothing when that is so already.
void forget(PairMemory& memory);

// After the step: who touches (impulse or closed gap), and overlaps that have opened; forget() without points. [first, last) are
// the points of this search; rows of `end_gap` and `impulse` (n x 3, in the points' frames) go with list.points.
void remember(const ContactList& list, std::size_t first, std::size_t last, const Points& end_gap, const Points& impulse,
              double closed, PairMemory& memory);

}  // namespace cbr
