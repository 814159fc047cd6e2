// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/pair_memory.hpp"

#include <algorithm>

namespace cbr {
namespace {

void touch(Index slot, Index face, PairMemory& memory) {
  if (memory.face[slot] < 0) {
    memory.face[slot] = memory.known_face[slot] = face;
    return;
  }
  if (memory.further_faces.empty()) return;
  const auto first =
      memory.further_faces.begin() + slot * static_cast<Index>(PairMemory::n_further);
  const auto place = std::find(first, first + PairMemory::n_further, -1);
  if (place != first + PairMemory::n_further) *place = face;
}

}  // namespace

void start_memory(Index n, PairMemory& memory) {
  if (memory.offset.size() != n) {
    memory.offset.setConstant(n, memory.rest);
    memory.face.assign(n, -1);
    memory.known_face.assign(n, -1);
  }
}

void renumber(const std::vector<EdgePair>& edges, PairMemory& memory) {
  if (edges == memory.edges) return;
  const PairMemory old = {.face = memory.face,
                          .known_face = memory.known_face,
                          .offset = memory.offset,
                          .impulse = memory.impulse,
                          .velocity = memory.velocity,
                          .elastic_slip = memory.elastic_slip,
                          .edges = memory.edges};
  const auto n = static_cast<Index>(edges.size());
  memory.edges = edges;
  memory.face.assign(edges.size(), -1);
  memory.known_face.assign(edges.size(), -1);
  memory.offset.setConstant(n, memory.rest);
  memory.forces.fill(Points(0, 3));  // slots are now of other edges
  if (old.impulse.rows() > 0) memory.impulse.setZero(n, 3);
  if (old.velocity.rows() > 0) memory.velocity.setConstant(n, 3, HUGE_VAL);
  if (old.elastic_slip.rows() > 0) memory.elastic_slip.setZero(n, 3);
  for (Index i = 0, k = 0; i < n; ++i) {
    const auto n_old = static_cast<Index>(old.edges.size());
    while (k < n_old && old.edges[k] < edges[i]) ++k;
    if (k == n_old || old.edges[k] != edges[i]) continue;
    memory.face[i] = old.face[k];
    memory.known_face[i] = old.known_face[k];
    memory.offset[i] = old.offset[k];
    if (old.impulse.rows() > 0) memory.impulse.row(i) = old.impulse.row(k);
    if (old.velocity.rows() > 0) memory.velocity.row(i) = old.velocity.row(k);
    if (old.elastic_slip.rows() > 0) memory.elastic_slip.row(i) = old.elastic_slip.row(k);
  }
}

double contact_reach(double size, double motion, bool initial, const PairMemory& memory) {
  const double reach =
      0.02 * size + 0.5 * motion + memory.adjust + memory.extra_reach + std::max(0.0, memory.rest);
  return initial ? std::max(reach, size) : reach;
}

void keep_overlap(Index slot, double from_surface, bool initial, PairMemory& memory) {
  // A gap or overlap of up to `adjust` is an error of the meshes. Beyond, interference applies to
  // the meshed distances, and a clearance allows them to be below 0
  const bool fits = initial && std::abs(from_surface) <= memory.adjust;
  double distance = from_surface;
  if (!initial) distance -= memory.rest_before;
  if (initial && !fits) distance -= std::min(0.0, memory.rest);
  if (initial) {
    memory.initial_overlap = std::max(memory.initial_overlap, -distance);
    if (distance >= 0) memory.initial_gap = std::min(memory.initial_gap, distance);
  }
  const double closed =
      initial ? (fits ? memory.adjust : 0.0) : std::max(0.0, memory.offset[slot] - memory.rest);
  memory.offset[slot] = memory.rest + (distance < 0 ? std::min(memory.kept_share * distance, closed)
                                                    : std::min(distance, closed));
}

void forget(PairMemory& memory) {
  if (!memory.has_points) return;
  memory.has_points = false;
  std::fill(memory.face.begin(), memory.face.end(), -1);
  std::fill(memory.known_face.begin(), memory.known_face.end(), -1);
  std::fill(memory.further_faces.begin(), memory.further_faces.end(), -1);
  memory.offset = memory.offset.cwiseMax(memory.rest);
  memory.impulse.setZero();
  for (Points& force : memory.forces) force.setZero();
  memory.velocity.setConstant(HUGE_VAL);
  memory.elastic_slip.setZero();
  memory.depth = 0;
}

void pass_without_force(Index n_steps, PairMemory& memory) {
  for (Index i = 0; i < std::min<Index>(n_steps, std::ssize(memory.forces)); ++i) {
    std::rotate(memory.forces.begin(), memory.forces.end() - 1, memory.forces.end());
    memory.forces[0].setZero();
  }
}

void remember(const ContactList& list, std::size_t first, std::size_t last, const Points& end_gap,
              const Points& impulse, double closed, PairMemory& memory,
              const std::function<bool(std::size_t point)>& pushes) {
  if (first == last) return forget(memory);
  memory.has_points = true;
  for (std::size_t i = first; i < last && memory.impulse.rows() > 0; ++i) {
    // closed points whose gap has changed before any motion: the weights have changed
    const ContactPoint& point = list.points[i];
    if (memory.impulse.row(point.slot).dot(point.normal()) > 0)
      memory.drift_taken += impulse(static_cast<Index>(i), 0) * point.start_gap;
  }
  std::fill(memory.face.begin(), memory.face.end(), -1);
  std::fill(memory.further_faces.begin(), memory.further_faces.end(), -1);
  memory.impulse.setZero(memory.offset.size(), 3);
  memory.depth = 0;
  for (std::size_t i = first; i < last; ++i) {
    const ContactPoint& point = list.points[i];
    const Index row = static_cast<Index>(i);
    const double gap = end_gap(row, 0);
    if (impulse(row, 0) > 0 || gap < closed || (pushes && pushes(i)))
      touch(point.slot, std::max<Index>(point.face, 0), memory);
    memory.impulse.row(point.slot) += impulse.row(row) * point.frame;
    // The gap counts from the offset: overlap that has opened stays open. The offset is that of the
    // node's first face
    double& offset = memory.offset[point.slot];
    memory.depth = std::max(memory.depth, -gap - offset);
    const bool is_first = i == first || list.points[i - 1].slot != point.slot;
    if (offset < memory.rest && is_first)
      offset = std::min(memory.rest, offset + std::max(0.0, gap));
  }
}

}  // namespace cbr
