// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/search: which nodes, faces and walls can touch in a step.
//
// Which slave nodes can touch which master faces in a step.
#pragma once

#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"
#include "dynamics/contact/surfaces/pair_memory.hpp"

namespace cbr {

// Lengths as shares of the master face's size, where nothing else is said.
struct DetectionOptions {
  // A node this far off a face still counts as over it: matching surfaces whose edges coincide stay
  // in contact at their edges although they slip a little (2 % of a face at the rim of the paper's
  // blocks, which are strained by 7 %).
  double edge_tolerance = 0.05;
  // The same for a node that has not touched a face that looks this way since the bodies were
  // apart: it is to pass by.
  double new_edge_tolerance = 1e-3;
  // A node that was not in contact may start a step this deep and still be caught; deeper, it is on
  // the other side of a thin body.
  double late_depth = 0.05;
  // A node that starts less deep than this behind a face may be just beside it, within the edge
  // tolerances.
  double kept_depth = 1e-3;
  // Slip since the last search up to which its points stand; 0: every step is searched.
  double standing_slip = 1e-3;
  // How much farther such a search reaches.
  double standing_reach = 0.05;
  // Mortar: of what a point is found deeper than it was left, at most this share of the largest
  // motion is pushed out in a step.
  double drift_share = 0.25;
  // False: the slave's nodes alone, as the tests' dense arithmetic searches.
  bool both_sides = true;

  // How far beyond a face's box the nodes may be that count as over it, as a share of the box: its
  // corners moved off a triangle's centre of area by 3, of a quad's by 2 edge tolerances; what is
  // twisted by its square.
  double overhang() const { return 2 * edge_tolerance * (1 + edge_tolerance); }
};

// Appends the contact points of a pair; slips are left 0. Positions are those of the bodies' start
// and predicted end; the path of a node relative to a face tells on which side it comes from, so
// that neither a large step nor a thin body lets it through. Further faces of a node are added when
// their normals differ by more than 45 degrees (a corner); those that rise from the first by more
// than 15 degrees as soon as the others would let it go into them. `initial`: first step of the
// run: nodes may overlap by up to a face's size and keep that overlap.
void detect(const ContactSurface& slave, const ContactBody& slave_body,
            const ContactSurface& master, const ContactBody& master_body, bool initial,
            const DetectionOptions& options, PairMemory& memory, ContactList& list);

// What is searched for beside the slave's nodes.
struct OtherSide {
  const ContactSurface& nodes;  // those of the master that are tested: all, or its ridge
  bool only_unheld = true;      // not where the slave's nodes hold the spot already
  PairMemory &back, &edges;
};

// Where the points of each search end in the list.
struct SearchEnds {
  std::size_t nodes = 0, back = 0, edges = 0;
};

// detect(), then the nodes of the master against the faces of the slave, then edges that cross.
SearchEnds detect_both(const ContactSurface& slave, const ContactBody& slave_body,
                       const ContactSurface& master, const ContactBody& master_body, bool initial,
                       const DetectionOptions& options, PairMemory& memory, const OtherSide& other,
                       ContactList& list);

}  // namespace cbr
