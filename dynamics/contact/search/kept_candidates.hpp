// SPDX-License-Identifier: GPL-3.0-or-later
// Candidates that are reused over several steps: a search with a skin stays valid until motions
// exceed the skin (Verlet 1967).
#pragma once

#include "dynamics/contact/surfaces/contact_surface.hpp"
#include "dynamics/contact/surfaces/pair_memory.hpp"

namespace cbr {

// Arguments of a search for candidates.
struct CandidateSearch {
  const ContactSurface &slave, &master;
  const ContactBody &slave_body, &master_body;
  Vector3 drift;          // mean motion of the master's nodes in the step
  double motion = 0;      // sum of the longest paths of both sides' nodes relative to it
  double margin = 0;      // largest distance of a candidate node and face,
  double size_share = 0;  // at least this fraction of the face's size,
  double overhang = 0;    // and in the plane of the face this fraction of its box
  double skin = 0;        // of candidates to reuse; 0: chosen by the motion of the step
};

// Arguments of the search beyond the slave's nodes.
struct FurtherSearch {
  const CandidateSearch& back;  // the master's nodes, and the slave's faces
  double edge_margin = 0;       // largest distance of candidate edges
  PairMemory &back_memory, &edge_memory;
};

// The swept box of a node, in axes that drift with the master.
Box node_box(const CandidateSearch& search, Index node);

// The swept box of a face, enlarged by the margins.
Box face_box(const CandidateSearch& search, Index face);

// Fills memory.grid.candidates: per slave node the faces whose swept boxes meet its own, and some
// more. With `further` also the candidates of its back memory, and edge_candidates of its edge
// memory. Searches only when the last candidates may be incomplete.
void update_candidates(const CandidateSearch& search, const FurtherSearch* further,
                       PairMemory& memory);

}  // namespace cbr
