// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/closeness.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/contact/search/edge_contact.hpp"
#include "dynamics/contact/search/kept_candidates.hpp"
#include "dynamics/contact/surfaces/pair_projection.hpp"

namespace cbr {
namespace {

// Times the mean face size: relative motion of the surfaces up to which candidates are reused.
constexpr double kept_skin = 1;

// Face nearest to a node.
struct Nearest {
  // depth: if the projection is behind the face, inside its edges
  double distance = HUGE_VAL, depth = 0;
  Vector3 normal = Vector3::Zero();
  Foot foot;
};

void take_nearer(const ContactSurface& faces, const ContactBody& body, Index face, const Vector3& x,
                 const Projection& p, Nearest& nearest) {
  Vector3 foot = Vector3::Zero();
  for (int a = 0; a < 4; ++a) foot += p.weights[a] * body.end.row(faces.faces(face, a)).transpose();
  const double distance = (x - foot).norm();
  if (distance >= nearest.distance) return;
  const bool is_behind = p.distance < 0 && p.outside <= 1e-9;
  nearest = {distance, is_behind ? distance : 0, p.normal, {face, p.weights}};
}

// Area vector of a surface's node: undeformed, rotated with the body.
Vector3 outward(const ContactSurface& surface, std::size_t slot, const ContactBody& body) {
  const Vector3 area = surface.area_vectors.row(static_cast<Index>(slot)).transpose();
  return body.turn ? Vector3(*body.turn * area) : area;
}

// Bounding balls of faces, around the means of their corners.
struct Balls {
  Points centre;
  Vector radius;

  Balls(const ContactSurface& faces, const ContactBody& body)
      : centre(faces.faces.rows(), 3), radius(faces.faces.rows()) {
    for (Index f = 0; f < centre.rows(); ++f) {
      const FaceCorners at = corners(faces, f, body.end);
      const Vector3 mean = 0.25 * (at[0] + at[1] + at[2] + at[3]);
      double most2 = 0;
      for (const Vector3& corner : at) most2 = std::max(most2, (corner - mean).squaredNorm());
      centre.row(f) = mean.transpose();
      radius[f] = std::sqrt(most2);
    }
  }
};

// Appends the candidate faces that can be nearest to a node. The ball of a face bounds its distance
// from below. The ball centres, and the corners of one face, bound the least distance from above.
void take_nearest(const CandidateSearch& search, const CandidateList& list, const Balls& balls,
                  Index slot, std::vector<NodeAndFace>& pairs) {
  constexpr double round_off = 1e-9;
  thread_local std::vector<double> distance;
  const Index node = search.slave.nodes[slot];
  const Eigen::RowVector3d x = search.slave_body.end.row(node);
  double most = HUGE_VAL;
  Index nearest = -1;
  distance.clear();
  for (Index k = list.first[slot]; k < list.first[slot + 1]; ++k) {
    distance.push_back((x - balls.centre.row(list.target[k])).norm());
    if (!(distance.back() < most)) continue;
    most = distance.back();
    nearest = list.target[k];
  }
  for (int a = 0; a < 4 && nearest >= 0; ++a)
    most = std::min(most, (x - search.master_body.end.row(search.master.faces(nearest, a))).norm());
  most += round_off * search.margin;
  for (Index k = list.first[slot]; k < list.first[slot + 1]; ++k) {
    const Index face = list.target[k];
    const double least = distance[k - list.first[slot]];
    if (!(least - balls.radius[face] > most)) pairs.push_back({node, face});
  }
}

Vector3 place_of(const CandidateSearch& search, const Foot& foot) {
  Vector3 x = Vector3::Zero();
  for (int a = 0; a < 4; ++a)
    x +=
        foot.weights[a] * search.master_body.end.row(search.master.faces(foot.face, a)).transpose();
  return x;
}

// The distance to any point of the surface bounds the depth of a node from above. The last
// projection point serves as such a point. Nodes whose bound is within the depth found so far are
// skipped.
class NodesAtFaces {
 public:
  NodesAtFaces(const CandidateSearch& search, const CandidateList& list, std::vector<Foot>& feet)
      : search_(search), list_(list), feet_(feet) {
    feet.resize(search.slave.nodes.size());
  }

  void look(Closeness& of) {
    thread_local std::vector<NodeAndFace> pairs;
    thread_local std::vector<std::size_t> first;
    thread_local std::vector<Index> slots;
    thread_local std::vector<PairProjection> found;
    const Balls balls(search_.master, search_.master_body);
    pairs.clear();
    slots.clear();
    first.assign(1, 0);
    for (std::size_t i = 0; i < feet_.size(); ++i) {
      const auto slot = static_cast<Index>(i);
      if (feet_[i].face >= 0 && most_depth(slot) <= of.depth) continue;
      take_nearest(search_, list_, balls, slot, pairs);
      slots.push_back(slot);
      first.push_back(pairs.size());
    }
    project_pairs(search_.master, search_.master_body, search_.slave_body, pairs, -HUGE_VAL, found);
    for (std::size_t i = 0; i < slots.size(); ++i) {
      Nearest nearest;
      for (std::size_t k = first[i]; k < first[i + 1]; ++k)
        take_nearer(search_.master, search_.master_body, pairs[k].face, at(slots[i]), found[k].end,
                    nearest);
      feet_[slots[i]] = nearest.foot;
      take(slots[i], nearest, of);
    }
  }

 private:
  Vector3 at(Index slot) const {
    return search_.slave_body.end.row(search_.slave.nodes[slot]).transpose();
  }

  // The tolerance covers the residual of Newton's method in projections of nodes onto faces.
  double most_depth(Index slot) const {
    constexpr double inexact = 1e-7;
    const Foot& foot = feet_[slot];
    return (at(slot) - place_of(search_, foot)).norm() + inexact * search_.margin;
  }

  void take(Index slot, const Nearest& nearest, Closeness& of) const {
    if (nearest.depth == 0) {
      of.gap = std::min(of.gap, nearest.distance);
    } else if (nearest.depth <= search_.margin &&
               nearest.normal.dot(outward(search_.slave, static_cast<std::size_t>(slot),
                                          search_.slave_body)) < 0) {
      of.depth = std::max(of.depth, nearest.depth);
    }
  }

  const CandidateSearch& search_;
  const CandidateList& list_;
  std::vector<Foot>& feet_;
};

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
                    const DetectionOptions& options, double known, ClosenessMemory& memory) {
  const CandidateSearch search{slave, master, slave_body, master_body, Vector3::Zero(),
                               0,     reach,  0,          0,           kept_skin * master.size};
  const CandidateSearch back{master, slave, master_body, slave_body, Vector3::Zero(),
                             0,      reach, 0,           0,          0};
  const FurtherSearch further{back, reach, memory.back, memory.edges};
  update_candidates(search, &further, memory.nodes);
  Closeness of;
  of.depth = known;
  NodesAtFaces(search, memory.nodes.grid.candidates, memory.feet).look(of);
  NodesAtFaces(back, memory.back.grid.candidates, memory.back_feet).look(of);
  look_at_edges({slave, master, slave_body, master_body, options, std::min(slave.size, master.size),
                 reach, 0, true},
                memory.edges.edge_candidates, of);
  return of;
}

}  // namespace cbr
