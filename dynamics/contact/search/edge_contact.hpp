// SPDX-License-Identifier: GPL-3.0-or-later
// Where edges cross, and which points of one side the other side's nodes hold already: theory.md,
// "Edges and corners".
#pragma once

#include <optional>
#include <vector>

#include "dynamics/contact/search/detection.hpp"

namespace cbr {

// A place where the surfaces may meet.
struct Spot {
  Vector3 normal;             // out of the master
  double start = 0, end = 0;  // gaps at the start and, without impulses, at the end of the step
  double size = 0;            // of the face there
};

// The points of one search, by the nodes that they are of.
class HeldNodes {
 public:
  // Points [first, last) of `list` are of `nodes`, ascending; `side` -1: their normals are out of
  // the slave. `memory` is that of the search. All must outlive it.
  HeldNodes(const ContactList& list, std::size_t first, std::size_t last,
            const std::vector<Index>& nodes, double side, const PairMemory& memory);

  // Whether one of the nodes of a face, or its neighbour, keeps the spot closed: contact is flat
  // there, and the node touches or ends as deep.
  bool hold(const ContactSurface& surface, Index face, const Spot& spot) const;

 private:
  bool holds(Index node, const Spot& spot) const;

  const ContactList& list_;
  std::size_t first_, last_;
  const std::vector<Index>& nodes_;
  double side_;
  const PairMemory& memory_;
  mutable std::vector<Index> point_of_;  // per node; made when first asked
};

// A sharp edge of one surface and an edge of the other that cross.
struct EdgeHit {
  EdgePair edges;
  Vector3 normal;                      // out of the master
  double on_slave = 0, on_master = 0;  // where they cross, as shares of their lengths from `a`
  double start_gap = 0, end_gap = 0;
};

// What a search for crossing edges is made for.
struct EdgeStep {
  const ContactSurface &slave, &master;
  const ContactBody &slave_body, &master_body;
  const DetectionOptions& options;
  double size = 0;    // of the finer surface's faces
  double reach = 0;   // gaps up to this are looked at
  double motion = 0;  // the longest ways of both sides' nodes, added up
  bool initial = false;
};

// Whether two edges meet as edges do, one of them being sharp: both bodies fall away from the
// plane that the edges span. The ends of a sharp edge are left to the nodes there.
std::optional<EdgeHit> cross(const EdgeStep& step, const EdgePair& edges, bool has_touched);

// Appends the points of memory.edge_candidates that no node holds.
void detect_edges(const EdgeStep& step, const std::vector<const HeldNodes*>& held,
                  PairMemory& memory, ContactList& list);

}  // namespace cbr
