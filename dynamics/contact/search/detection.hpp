// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/search: which nodes, faces and walls can touch in a step.
#pragma once

#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"
#include "dynamics/contact/surfaces/pair_memory.hpp"

namespace cbr {

// Lengths are relative to the size of the master face unless stated otherwise.
struct DetectionOptions {
  // A node outside a face by less still counts as over it. Matching surfaces whose edges coincide
  // so stay in contact at their edges when they slip a little. At the rim of the paper's blocks, at
  // 7 % strain, the slip is 2 % of a face.
  double edge_tolerance = 0.05;
  // The same for a node that has not touched a face of similar orientation since the bodies were
  // apart. It is small so that the node can pass by.
  double new_edge_tolerance = 1e-3;
  // Largest initial penetration of a node that was not in contact. A deeper node is on the other
  // side of a thin body.
  double late_depth = 0.05;
  // A node that penetrates by less at the start may be beside the face, within the edge tolerances.
  double kept_depth = 1e-3;
  // Slip since the last search up to which its points are reused; 0: searches in every step.
  double standing_slip = 1e-3;
  // Extra reach of a search that is reused.
  double standing_reach = 0.05;
  // Mortar: the largest part of a drift that one step removes, as a fraction of the largest motion
  // in the step. A drift is penetration that changed weights caused.
  double drift_share = 0.25;
  // False: tests the slave's nodes only, as the dense reference of the tests does.
  bool both_sides = true;

  // Largest distance beyond a face's bounding box of a node that counts as over it, relative to the
  // box. Edge tolerances move a triangle's corners off its centroid by 3 tolerances, a quad's by 2;
  // a twisted face adds their square.
  double overhang() const { return 2 * edge_tolerance * (1 + edge_tolerance); }
};

// Appends the contact points of a pair; slips stay 0. Positions are those of the bodies' start and
// predicted end. The path of a node relative to a face decides the side from which it comes. So
// nodes do not pass through at large steps or thin bodies. Further faces of a node are added where
// normals differ by more than 45 degrees (a corner). Faces that rise from the first by more than 15
// degrees are added as soon as the other faces would let the node enter them. `initial`: first step
// of the run; nodes may penetrate by up to a face's size and keep that overlap.
void detect(const ContactSurface& slave, const ContactBody& slave_body,
            const ContactSurface& master, const ContactBody& master_body, bool initial,
            const DetectionOptions& options, PairMemory& memory, ContactList& list);

// Arguments of the search beyond the slave's nodes.
struct OtherSide {
  const ContactSurface& nodes;  // tested nodes of the master: all, or its ridge
  bool only_unheld = true;      // skip places that the slave's nodes constrain already
  PairMemory &back, &edges;
};

// End of each search's points in the list.
struct SearchEnds {
  std::size_t nodes = 0, back = 0, edges = 0;
};

// detect() for the slave's nodes, then for master nodes against slave faces, then crossing edges.
SearchEnds detect_both(const ContactSurface& slave, const ContactBody& slave_body,
                       const ContactSurface& master, const ContactBody& master_body, bool initial,
                       const DetectionOptions& options, PairMemory& memory, const OtherSide& other,
                       ContactList& list);

}  // namespace cbr
