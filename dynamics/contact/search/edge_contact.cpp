// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/edge_contact.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {
namespace {

// Times the face size. A node constrains a spot too if it ends at most `as_deep` in front of it. It
// does not if it starts shallower than the spot by more than `less_deep`.
constexpr double as_deep = 1e-3, less_deep = 0.01;
constexpr double as_deep_on_paper = 1e-9;
// Sine of the angle below which edges count as parallel: their end nodes constrain them.
constexpr double nearly_parallel = 0.05;
// Sine of 15 degrees: the angle by which a face may rise from the plane of the edges.
constexpr double flat_rise = 0.26;
// Fraction of the edge near its ends where the nodes act instead.
constexpr double at_end = 1e-3;

struct Segments {
  Vector3 slave_a, slave_b, master_a, master_b;
};

Segments between(const Segments& a, const Segments& b, double t) {
  return {(1 - t) * a.slave_a + t * b.slave_a, (1 - t) * a.slave_b + t * b.slave_b,
          (1 - t) * a.master_a + t * b.master_a, (1 - t) * a.master_b + t * b.master_b};
}

// Shortest connection of two lines: their common unit normal and the signed distance along it.
struct Crossing {
  Vector3 normal;
  double on_slave = 0, on_master = 0, gap = 0;
  double per_length = 0;  // largest first-order change of the shares for unit motion of the ends
};

std::optional<Crossing> crossing(const Segments& x) {
  const Vector3 u = x.slave_b - x.slave_a, v = x.master_b - x.master_a, n = u.cross(v),
                r = x.slave_a - x.master_a;
  const double n2 = n.squaredNorm(), u2 = u.squaredNorm(), v2 = v.squaredNorm();
  if (!(n2 > nearly_parallel * nearly_parallel * u2 * v2)) return std::nullopt;
  Crossing of;
  of.normal = n / std::sqrt(n2);
  of.on_slave = v.cross(r).dot(n) / n2;
  of.on_master = u.cross(r).dot(n) / n2;
  of.gap = of.normal.dot(r);
  of.per_length = std::sqrt(std::max(u2, v2) / n2);
  return of;
}

Segments segments(const EdgeStep& step, const EdgePair& edges, Points ContactBody::*at) {
  const SurfaceEdge &slave = step.slave.edges[edges.slave],
                    &master = step.master.edges[edges.master];
  const Points &xs = step.slave_body.*at, &xm = step.master_body.*at;
  return {xs.row(slave.a).transpose(), xs.row(slave.b).transpose(), xm.row(master.a).transpose(),
          xm.row(master.b).transpose()};
}

bool is_within(const SurfaceEdge& edge, double share, double slack = 0) {
  const double least = (edge.sharp ? at_end : -1e-9) - slack;
  return share >= least && share <= 1 - least;
}

// Beyond the same end of the edge at both times.
bool stays_beyond(const SurfaceEdge& edge, double before, double after) {
  const double least = edge.sharp ? at_end : -1e-9;
  return std::max(before, after) < least || std::min(before, after) > 1 - least;
}

// Whether both wedges are on opposite sides of the plane.
bool is_between(const EdgeWedge& slave, const EdgeWedge& master, const Vector3& normal) {
  for (std::size_t i = 0; i < 2; ++i)
    if (slave.inward[i].dot(normal) < -flat_rise || master.inward[i].dot(normal) > flat_rise)
      return false;
  return true;
}

// The side of a rim is no part of the surface: contact there is not asked for, and rims at both
// ends of a bore would overlap by its length.
bool faces(const SurfaceEdge& edge, const EdgeWedge& wedge, const Vector3& out) {
  constexpr double least = 0.2;  // cosine
  return edge.faces[1] >= 0 || wedge.normal[0].dot(out) > least;
}

double gap_of(const EdgeHit& hit, const Segments& x) {
  const Vector3 slave = x.slave_a + hit.on_slave * (x.slave_b - x.slave_a),
                master = x.master_a + hit.on_master * (x.master_b - x.master_a);
  return hit.normal.dot(slave - master);
}

void add_edge_point(const EdgeStep& step, const EdgeHit& hit, Index slot, double offset,
                    ContactList& list) {
  const SurfaceEdge &slave = step.slave.edges[hit.edges.slave],
                    &master = step.master.edges[hit.edges.master];
  ContactPoint point;
  point.frame = contact_frame(hit.normal);
  point.gap[0] = hit.end_gap - offset;
  point.start_gap = hit.start_gap - offset;
  point.slot = slot;
  point.face = master.faces[0];
  point.first_term = static_cast<Index>(list.terms.size());
  const auto add = [&](const ContactSurface& surface, Index node, double coefficient) {
    if (coefficient != 0) list.terms.push_back({surface.body, node, coefficient});
  };
  const double s = std::clamp(hit.on_slave, 0.0, 1.0), t = std::clamp(hit.on_master, 0.0, 1.0);
  add(step.slave, slave.a, 1 - s);
  add(step.slave, slave.b, s);
  point.n_slave_terms = static_cast<Index>(list.terms.size()) - point.first_term;
  add(step.master, master.a, t - 1);
  add(step.master, master.b, -t);
  point.n_terms = static_cast<Index>(list.terms.size()) - point.first_term;
  list.points.push_back(point);
}

// Edges that meet in a node cross the same sharp edge at one place: one point is enough.
bool is_same_place(const EdgeStep& step, const EdgeHit& a, const EdgeHit& b) {
  if (a.edges.slave == b.edges.slave && step.slave.edges[a.edges.slave].sharp)
    return std::abs(a.on_slave - b.on_slave) < at_end;
  if (a.edges.master == b.edges.master && step.master.edges[a.edges.master].sharp)
    return std::abs(a.on_master - b.on_master) < at_end;
  return false;
}

void keep_deepest(const EdgeStep& step, const EdgeHit& hit, std::vector<EdgeHit>& hits) {
  const auto same = std::find_if(hits.begin(), hits.end(), [&](const EdgeHit& other) {
    return is_same_place(step, hit, other);
  });
  if (same == hits.end()) return hits.push_back(hit);
  // Equal depths within round-off: the first one, so that the choice is the same in every step
  if (hit.end_gap < same->end_gap - as_deep_on_paper * step.size) *same = hit;
}

// rest: PairMemory::rest
bool is_held(const EdgeStep& step, const std::vector<const HeldNodes*>& held, double rest,
             const EdgeHit& hit) {
  const Spot spot{hit.normal, hit.start_gap - rest, hit.end_gap - rest, step.size};
  const auto by = [&](const ContactSurface& surface, const SurfaceEdge& edge,
                      const HeldNodes& nodes) {
    return std::any_of(edge.faces.begin(), edge.faces.end(),
                       [&](Index face) { return face >= 0 && nodes.hold(surface, face, spot); });
  };
  return by(step.slave, step.slave.edges[hit.edges.slave], *held[0]) ||
         by(step.master, step.master.edges[hit.edges.master], *held[1]);
}

}  // namespace

HeldNodes::HeldNodes(const ContactList& list, std::size_t first, std::size_t last,
                     const std::vector<Index>& nodes, double side, const PairMemory& memory)
    : list_(list), first_(first), last_(last), nodes_(nodes), side_(side), memory_(memory) {}

bool HeldNodes::hold(const ContactSurface& surface, Index face, const Spot& spot) const {
  if (first_ == last_) return false;
  if (point_of_.empty()) {
    point_of_.assign(nodes_.size(), -1);
    for (std::size_t i = last_; i-- > first_;)
      point_of_[list_.points[i].slot] = static_cast<Index>(i);
  }
  for (int a = 0; a < n_corners(surface, face); ++a)
    if (holds(surface.faces(face, a), spot)) return true;
  return false;
}

bool HeldNodes::holds(Index node, const Spot& spot) const {
  const auto at = std::lower_bound(nodes_.begin(), nodes_.end(), node);
  if (at == nodes_.end() || *at != node) return false;
  const auto slot = at - nodes_.begin();
  const Index first = point_of_[slot];
  const double overlap = memory_.offset[slot] - memory_.lift(slot);  // at most 0
  const bool touched = memory_.face[slot] >= 0;
  for (auto i = static_cast<std::size_t>(first); first >= 0 && i < last_; ++i) {
    const ContactPoint& point = list_.points[i];
    if (point.slot != slot) break;
    const bool is_closed = touched || point.gap[0] + overlap <= spot.end + as_deep * spot.size;
    if (is_closed && side_ * point.normal().dot(spot.normal) >= nearly_flat &&
        spot.start >= point.start_gap + overlap - less_deep * spot.size)
      return true;
  }
  return false;
}

std::optional<EdgeHit> cross(const EdgeStep& step, const EdgePair& edges, bool has_touched) {
  const Segments end = segments(step, edges, &ContactBody::end);
  auto at = crossing(end);
  if (!at) return std::nullopt;
  // No motion of this step can close a larger distance
  const double size = step.size,
               deepest = (has_touched || step.initial) ? size : step.options.late_depth * size;
  if (std::abs(at->gap) > std::max(step.reach, deepest) + 2 * step.motion) return std::nullopt;
  const SurfaceEdge &slave = step.slave.edges[edges.slave],
                    &master = step.master.edges[edges.master];
  // Rejects most pairs early: a few times the possible motion of the ends
  const double slack = 4 * step.motion * at->per_length;
  if (!is_within(slave, at->on_slave, slack) || !is_within(master, at->on_master, slack))
    return std::nullopt;
  const Segments start = segments(step, edges, &ContactBody::start);
  const auto before = crossing(start);
  if (!before || stays_beyond(slave, before->on_slave, at->on_slave) ||
      stays_beyond(master, before->on_master, at->on_master))
    return std::nullopt;
  const EdgeWedge of_slave = wedge_at(step.slave, slave, step.slave_body.end),
                  of_master = wedge_at(step.master, master, step.master_body.end);
  const double side = at->normal.dot(of_master.outward() - of_slave.outward()) >= 0 ? 1 : -1;
  const double g0 = side * before->gap, g1 = side * at->gap;
  if (has_touched || g0 <= 0) {
    at = before;
  } else if (g1 < 0) {
    at = crossing(between(start, end, g0 / (g0 - g1)));
    if (!at) return std::nullopt;
  }
  if (!is_within(slave, at->on_slave) || !is_within(master, at->on_master)) return std::nullopt;
  EdgeHit hit{edges, side * at->normal, at->on_slave, at->on_master, 0, 0};
  if (!is_between(of_slave, of_master, hit.normal) || !faces(master, of_master, hit.normal) ||
      !faces(slave, of_slave, -hit.normal))
    return std::nullopt;
  hit.start_gap = gap_of(hit, start);
  hit.end_gap = gap_of(hit, end);
  if (hit.end_gap > step.reach || hit.start_gap < -deepest) return std::nullopt;
  return hit;
}

void detect_edges(const EdgeStep& step, const std::vector<const HeldNodes*>& held,
                  PairMemory& memory, ContactList& list) {
  thread_local std::vector<EdgeHit> hits;
  hits.clear();
  std::vector<EdgePair> known;  // of this step
  std::size_t next = 0;
  for (const EdgePair& edges : memory.edge_candidates) {
    while (next < memory.edges.size() && memory.edges[next] < edges) ++next;
    const bool is_known = next < memory.edges.size() && memory.edges[next] == edges;
    const auto hit = cross(step, edges, is_known && memory.face[next] >= 0);
    if (!hit || is_held(step, held, memory.rest, *hit)) continue;
    keep_deepest(step, *hit, hits);
  }
  for (const EdgeHit& hit : hits) known.push_back(hit.edges);
  for (std::size_t i = 0; i < memory.edges.size(); ++i)  // adjusted gaps stay closed
    if (memory.offset[static_cast<Index>(i)] > memory.rest) known.push_back(memory.edges[i]);
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  renumber(known, memory);
  for (const EdgeHit& hit : hits) {
    const auto slot =
        static_cast<Index>(std::lower_bound(known.begin(), known.end(), hit.edges) - known.begin());
    if (step.initial || (memory.face[slot] < 0 && hit.start_gap < memory.rest))
      keep_overlap(slot, hit.start_gap, step.initial, memory);
    add_edge_point(step, hit, slot, memory.offset[slot], list);
  }
}

}  // namespace cbr
