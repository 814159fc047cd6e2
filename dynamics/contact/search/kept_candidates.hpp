// SPDX-License-Identifier: GPL-3.0-or-later
// Candidates that serve several steps: faces that are near a node, found with a skin around them
// that motions first have to use up (Verlet 1967).
#pragma once

#include "dynamics/contact/surfaces/contact_surface.hpp"
#include "dynamics/contact/surfaces/pair_memory.hpp"

namespace cbr {

// What a search of candidates is made for.
struct CandidateSearch {
  const ContactSurface &slave, &master;
  const ContactBody &slave_body, &master_body;
  Vector3 drift;          // mean motion of the master's nodes in the step
  double motion = 0;      // the longest ways of both sides' nodes relative to it, added up
  double margin = 0;      // a node is near a face within this,
  double size_share = 0;  // within this share of the face's size,
  double overhang = 0;    // and beside it within this share of its box
  double skin = 0;        // of what is kept; 0: chosen by the motion of the step
};

// What is searched for beside the slave's nodes.
struct FurtherSearch {
  const CandidateSearch& back;  // the master's nodes, and the slave's faces
  double edge_margin = 0;       // edges are near each other within this
  PairMemory &back_memory, &edge_memory;
};

// The box that a node sweeps, in axes that drift with the master.
Box node_box(const CandidateSearch& search, Index node);

// The box that a face sweeps, and within which it is near.
Box face_box(const CandidateSearch& search, Index face);

// Fills memory.grid.candidates with the faces that each slave node is near, by the boxes that both
// sweep, and some more; with `further` likewise that of its back memory, and the edge_candidates of
// its edge memory. Searches when what was found last may be short of one.
void update_candidates(const CandidateSearch& search, const FurtherSearch* further,
                       PairMemory& memory);

}  // namespace cbr
