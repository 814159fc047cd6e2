// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/closeness.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/contact/search/edge_contact.hpp"
#include "dynamics/contact/search/kept_candidates.hpp"
#include "dynamics/contact/surfaces/pair_projection.hpp"

namespace cbr {
namespace {

// Of a node: the nearest face.
struct Nearest {
  double distance = HUGE_VAL, depth = 0;  // depth: straight behind the face
  Vector3 normal = Vector3::Zero();
};

void take_nearer(const ContactSurface& faces, const ContactBody& body, Index face, const Vector3& x,
                 const Projection& p, Nearest& nearest) {
  Vector3 foot = Vector3::Zero();
  for (int a = 0; a < 4; ++a) foot += p.weights[a] * body.end.row(faces.faces(face, a)).transpose();
  const double distance = (x - foot).norm();
  if (distance >= nearest.distance) return;
  const bool is_behind = p.distance < 0 && p.outside <= 1e-9;
  nearest = {distance, is_behind ? distance : 0, p.normal};
}

// Of the node of a surface, undeformed, as the body has turned.
Vector3 outward(const ContactSurface& surface, std::size_t slot, const ContactBody& body) {
  const Vector3 area = surface.area_vectors.row(static_cast<Index>(slot)).transpose();
  return body.turn ? Vector3(*body.turn * area) : area;
}

void look_at_nodes(const CandidateSearch& search, const CandidateList& list, Closeness& of) {
  thread_local std::vector<NodeAndFace> pairs;
  thread_local std::vector<PairProjection> found;
  pairs.clear();
  for (std::size_t i = 0; i < search.slave.nodes.size(); ++i)
    for (Index k = list.first[i]; k < list.first[i + 1]; ++k)
      pairs.push_back({search.slave.nodes[i], list.target[k]});
  project_pairs(search.master, search.master_body, search.slave_body, pairs, -HUGE_VAL, found);
  for (std::size_t i = 0; i < search.slave.nodes.size(); ++i) {
    const Vector3 x = search.slave_body.end.row(search.slave.nodes[i]).transpose();
    Nearest nearest;
    for (Index k = list.first[i]; k < list.first[i + 1]; ++k)
      take_nearer(search.master, search.master_body, list.target[k], x,
                  found[static_cast<std::size_t>(k)].end, nearest);
    if (nearest.depth == 0) {
      of.gap = std::min(of.gap, nearest.distance);
    } else if (nearest.depth <= search.margin &&
               nearest.normal.dot(outward(search.slave, i, search.slave_body)) < 0) {
      of.depth = std::max(of.depth, nearest.depth);
    }
  }
}

void look_at_edges(const EdgeStep& step, const std::vector<EdgePair>& edges, Closeness& of) {
  for (const EdgePair& pair : edges) {
    const auto hit = cross(step, pair, false);
    if (!hit) continue;
    of.depth = std::max(of.depth, -hit->start_gap);
    if (hit->start_gap >= 0) of.gap = std::min(of.gap, hit->start_gap);
  }
}

}  // namespace

Closeness closeness(const ContactSurface& slave, const ContactBody& slave_body,
                    const ContactSurface& master, const ContactBody& master_body, double reach,
                    const DetectionOptions& options) {
  const CandidateSearch search{slave, master, slave_body, master_body, Vector3::Zero(), 0,
                               reach, 0,      0};
  const CandidateSearch back{master, slave, master_body, slave_body, Vector3::Zero(),
                             0,      reach, 0,           0};
  PairMemory nodes, back_nodes, edges;
  const FurtherSearch further{back, reach, back_nodes, edges};
  update_candidates(search, &further, nodes);
  Closeness of;
  look_at_nodes(search, nodes.grid.candidates, of);
  look_at_nodes(back, back_nodes.grid.candidates, of);
  look_at_edges({slave, master, slave_body, master_body, options, std::min(slave.size, master.size),
                 reach, 0, true},
                edges.edge_candidates, of);
  return of;
}

}  // namespace cbr
