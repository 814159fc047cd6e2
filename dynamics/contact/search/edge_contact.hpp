// SPDX-License-Identifier: GPL-3.0-or-later
// Crossing edges, and places that nodes of the other side constrain already: theory.md, "Edges and
// corners".
#pragma once

#include <optional>
#include <vector>

#include "dynamics/contact/search/detection.hpp"

namespace cbr {

// A possible place of contact.
struct Spot {
  Vector3 normal;             // out of the master
  double start = 0, end = 0;  // gaps at the start and, without impulses, at the end of the step
  double size = 0;            // of the face there
};

// Contact points of one search, by node.
class HeldNodes {
 public:
  // Points [first, last) of `list` belong to `nodes`, ascending. `side` -1: their normals point out
  // of the slave. `memory` is that of the search. All must outlive this object.
  HeldNodes(const ContactList& list, std::size_t first, std::size_t last,
            const std::vector<Index>& nodes, double side, const PairMemory& memory);

  // Whether a node of the face, or a neighbour of one, keeps the spot closed. Contact is flat
  // there, and the node touches or ends as deep.
  bool hold(const ContactSurface& surface, Index face, const Spot& spot) const;

 private:
  bool holds(Index node, const Spot& spot) const;

  const ContactList& list_;
  std::size_t first_, last_;
  const std::vector<Index>& nodes_;
  double side_;
  const PairMemory& memory_;
  mutable std::vector<Index> point_of_;  // per node; filled at the first use
};

// A sharp edge of one surface that crosses an edge of the other.
struct EdgeHit {
  EdgePair edges;
  Vector3 normal;                      // out of the master
  double on_slave = 0, on_master = 0;  // where they cross: fraction of their lengths from `a`
  double start_gap = 0, end_gap = 0;
};

// Arguments of a search for crossing edges.
struct EdgeStep {
  const ContactSurface &slave, &master;
  const ContactBody &slave_body, &master_body;
  const DetectionOptions& options;
  double size = 0;    // of the finer surface's faces
  double reach = 0;   // largest gap of interest
  double motion = 0;  // sum of the longest paths of both sides' nodes
  bool initial = false;
};

// Whether two edges, one of them sharp, meet as edges: both bodies lie on opposite sides of the
// plane that the edges span. Nodes act at the ends of a sharp edge.
std::optional<EdgeHit> cross(const EdgeStep& step, const EdgePair& edges, bool has_touched);

// Appends the points of memory.edge_candidates that no node constrains.
void detect_edges(const EdgeStep& step, const std::vector<const HeldNodes*>& held,
                  PairMemory& memory, ContactList& list);

}  // namespace cbr
