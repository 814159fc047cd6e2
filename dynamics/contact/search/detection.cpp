// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/detection.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/contact/search/closeness.hpp"
#include "dynamics/contact/search/edge_contact.hpp"
#include "dynamics/contact/search/hollow_corners.hpp"
#include "dynamics/contact/search/kept_candidates.hpp"
#include "dynamics/contact/surfaces/pair_projection.hpp"

namespace cbr {
namespace {

// Times the face size: gaps that differ by less are equal within round-off.
constexpr double same_gap = 1e-9;

struct Step : DetectionStep {
  const ContactSurface& slave;
  const ContactBody& slave_body;
  bool initial;
  const CandidateSearch& search;
  const HeldNodes* held = nullptr;  // nodes constrained by these are left out
};

// Whether a face constrains a node that starts the step behind it. A node beside an edge of a body
// is behind the faces of both sides. A face that it has neither touched nor lies under must not
// push it out.
bool held_from_behind(const Step& step, const Projection& before, const FaceHit& hit, double size,
                      double edge) {
  const double depth = -hit.start_gap;
  if (hit.follows) return depth <= size && (before.outside <= edge || hit.over_at_end);
  if (step.initial) return depth <= size && before.outside <= edge;
  if (depth <= step.options.kept_depth * size) return before.outside <= edge;
  return depth <= step.options.late_depth * size && before.outside <= 1e-9;
}

// Whether the node is over the moving face when it crosses it. Regula falsi finds that time, so
// that a ridge between two faces has no gap.
bool passes_through(const FaceCorners& start, const FaceCorners& end, bool triangle,
                    const SlaveNode& node, FaceHit& hit, double size, double edge) {
  double t0 = 0, t1 = 1, d0 = hit.start_gap, d1 = hit.end_gap, outside = 0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    const double t = t0 + (t1 - t0) * d0 / (d0 - d1);
    FaceCorners at;
    for (int a = 0; a < 4; ++a) at[a] = (1 - t) * start[a] + t * end[a];
    const Projection p = project(at, triangle, (1 - t) * node.start + t * node.end);
    const double d = p.distance - node.lift;
    hit.entry = t;
    outside = p.outside;
    if (std::abs(d) <= 1e-9 * size) break;
    (d > 0 ? t0 : t1) = t, (d > 0 ? d0 : d1) = d;
  }
  return outside <= edge;
}

// Whether a node is beside the face during the whole step, judged by its start and end. In local
// coordinates of the face its path is curved by a small fraction of its length.
bool stays_beside(const PairProjection& found, double edge) {
  const FacePlace &from = found.before.place, &to = found.end.place;
  const double way = std::abs(to.xi - from.xi) + std::abs(to.eta - from.eta);
  const double most = 1 + 2 * edge + 0.1 * way;
  const auto is_beyond = [&](double a, double b) {
    return std::max(a, b) < -most || std::min(a, b) > most;
  };
  return way < 0.5 && (is_beyond(from.xi, to.xi) || is_beyond(from.eta, to.eta));
}

// Whether a node is over the face during the whole step by a clear margin, judged likewise.
bool stays_over(const PairProjection& found, double edge) {
  const FacePlace &from = found.before.place, &to = found.end.place;
  const double way = std::abs(to.xi - from.xi) + std::abs(to.eta - from.eta);
  constexpr double clearly = 0.01;
  const double outside = std::max(found.before.outside, found.end.outside);
  return way < 0.5 && outside + 0.05 * way + clearly < edge;
}

// For a node that starts on the face within round-off: whether it is over the face when it crosses
// it. It crosses at once, or its whole path is that short. Undecided near the edge.
std::optional<bool> passes_from_face(const PairProjection& found, double size, double edge,
                                     FaceHit& hit) {
  constexpr double unsure = 0.01;
  if (hit.start_gap > 1e-9 * size) return std::nullopt;
  hit.entry = hit.start_gap / (hit.start_gap - hit.end_gap);
  const double outside = (1 - hit.entry) * found.before.outside + hit.entry * found.end.outside;
  if (!(std::abs(outside - edge) > unsure)) return std::nullopt;
  return outside <= edge;
}

// Whether the swept boxes of node and face meet. Reused candidates include more faces, and contact
// points must not depend on that. The test is skipped where node and face are closer than any box's
// margin.
bool is_near(const Step& step, const SlaveNode& node, const PairProjection& found, Index face) {
  const CandidateSearch& search = step.search;
  const double half = 0.5 * std::max(search.margin, search.size_share * step.master.sizes[face]);
  const auto is_inside = [&](const Projection& p) {
    return p.outside <= step.options.edge_tolerance && std::abs(p.distance) <= half;
  };
  if (is_inside(found.before) || is_inside(found.end)) return true;
  return node_box(search, step.slave.nodes[node.slot]).meets(face_box(search, face));
}

// Whether the node crossed the face during the step, touches it or is near it; fills `hit`.
bool meets(const Step& step, const SlaveNode& node, Index face, const PairProjection& found,
           FaceHit& hit) {
  if (!(found.end.distance <= step.reach)) return false;
  const double size = step.master.sizes[face];
  if (!(size > 0) || found.end.normal.isZero()) return false;
  const Projection& before = found.before;
  hit.start_gap = before.distance - node.lift;
  const bool known = before.normal.dot(node.known_normal) >= same_side;
  const double edge = known ? step.options.edge_tolerance : step.options.new_edge_tolerance;
  hit.face = face;
  hit.end = found.end;
  hit.outside = before.outside;
  hit.over_now = before.outside <= step.options.new_edge_tolerance;
  hit.over_at_end = hit.end.outside <= edge;
  hit.right_over_at_end = hit.end.outside <= step.options.new_edge_tolerance;
  hit.nearly_over = hit.end.outside <= step.options.edge_tolerance;
  hit.same = node.face == face;
  hit.follows = node.face >= 0 && before.normal.dot(node.normal) >= same_side;
  const FaceCorners end = corners(step.master, face, step.master_body.end);
  if (hit.follows && before.outside <= edge) touch_where_it_is(before, end, node.end, hit.end);
  hit.end_gap = hit.end.distance - node.lift;
  hit.entry = hit.start_gap / size;
  hit.entry_is_rough = false;
  if (hit.start_gap <= 0) {
    if (!held_from_behind(step, before, hit, size, edge)) return false;
    return (hit.end_gap < 0 || hit.over_at_end) && is_near(step, node, found, face);
  }
  hit.entry = 1;
  if (hit.end_gap >= 0) return hit.over_at_end && is_near(step, node, found, face);
  if (stays_beside(found, edge)) return false;
  if (const auto passes = passes_from_face(found, size, edge, hit))
    return *passes && is_near(step, node, found, face);
  if (stays_over(found, edge)) {
    hit.entry = hit.start_gap / (hit.start_gap - hit.end_gap);
    hit.entry_is_rough = true;
    return is_near(step, node, found, face);
  }
  const FaceCorners start = corners(step.master, face, step.master_body.start);
  return passes_through(start, end, is_triangle(step.master, face), node, hit, size, edge) &&
         is_near(step, node, found, face);
}

// Order of the faces that constrain a node. The touched face comes first until the node is off its
// edge and over the next one. Entry times are rounded, so that the end of the step decides between
// coplanar faces. size: of the faces, for the round-off of gaps.
bool better(const FaceHit& a, const FaceHit& b, double size) {
  if (a.over_at_end != b.over_at_end) return a.over_at_end;
  if (a.follows != b.follows) return a.follows;
  if (a.follows && a.over_now != b.over_now) return a.over_now;
  if (a.same != b.same) return a.same;
  // In a valley the node crosses the neighbouring face last. Without this rule a node that lost
  // contact for one step would sink into the face below it.
  if (!a.follows && a.right_over_at_end != b.right_over_at_end) return a.right_over_at_end;
  const double entry_a = std::round(1e10 * a.entry), entry_b = std::round(1e10 * b.entry);
  if (entry_a != entry_b) return entry_a > entry_b;
  return std::abs(a.end_gap) < std::abs(b.end_gap) - same_gap * size;
}

// Blends normals near an edge between faces of similar orientation. The normal of a touching node
// changes continuously as it slides across, so that forces do not jump. A node on the edge itself,
// or arriving there, has the mean normal and so no preferred side.
void blend_normals(const Step& step, const SlaveNode& node, std::vector<FaceHit>& hits) {
  constexpr double nearly_same_way = 0.866;  // 30 degrees
  constexpr double bent = 1e-10;  // faces with a smaller difference of normals are coplanar
  FaceHit& first = hits.front();
  const double size = step.master.sizes[first.face];
  Vector3 sum = first.end.normal;
  for (std::size_t i = 1; i < hits.size(); ++i) {
    const FaceHit& hit = hits[i];
    if (rises_from(step.master, hit.face, first.face)) continue;
    if (hit.end.normal.dot(first.end.normal) < nearly_same_way) continue;
    double share = 0;
    if (first.follows) {
      if (hit.follows) share = 1 - std::max(0.0, hit.outside) / step.options.edge_tolerance;
    } else if (!better(first, hit, size) && (hit.end.normal - first.end.normal).norm() > bent) {
      share = 1;
    }
    if (share > 0) sum += share * hit.end.normal;
  }
  if (!first.follows && sum == first.end.normal) return;
  first.end.normal = sum.normalized();
  Vector3 foot = Vector3::Zero();
  for (int a = 0; a < 4; ++a)
    foot += first.end.weights[a] *
            step.master_body.end.row(step.master.faces(first.face, a)).transpose();
  first.end.distance = first.end.normal.dot(node.end - foot);
  first.end_gap = first.end.distance - node.lift;
}

void add_point(const Step& step, const SlaveNode& node, const FaceHit& hit, double offset,
               ContactList& list) {
  ContactPoint point;
  point.frame = contact_frame(hit.end.normal);
  point.gap[0] = hit.end_gap + node.lift - offset;
  point.start_gap = hit.start_gap + node.lift - offset;
  point.area = facing_area(step.slave, node.slot, step.slave_body, point.normal());
  point.slot = node.slot;
  point.face = hit.face;
  point.first_term = static_cast<Index>(list.terms.size());
  list.terms.push_back({step.slave.body, step.slave.nodes[node.slot], 1});
  for (int a = 0; a < 4; ++a)
    if (hit.end.weights[a] != 0)
      list.terms.push_back({step.master.body, step.master.faces(hit.face, a), -hit.end.weights[a]});
  point.n_terms = static_cast<Index>(list.terms.size()) - point.first_term;
  list.points.push_back(point);
}

SlaveNode node_of(const Step& step, Index slot, const PairMemory& memory) {
  const Index i = step.slave.nodes[slot];
  SlaveNode node;
  node.slot = slot;
  node.start = step.slave_body.start.row(i).transpose();
  node.end = step.slave_body.end.row(i).transpose();
  node.face = memory.face[slot];
  const Index known = memory.known_face[slot];
  if (known >= 0)
    node.known_normal = mean_normal(corners(step.master, known, step.master_body.start));
  if (node.face >= 0)
    node.normal = node.face == known
                      ? node.known_normal
                      : mean_normal(corners(step.master, node.face, step.master_body.start));
  node.lift = memory.lift(slot);
  if (!memory.further_faces.empty())
    node.further =
        std::span(memory.further_faces)
            .subspan(static_cast<std::size_t>(slot) * PairMemory::n_further, PairMemory::n_further);
  return node;
}

// Computes the exact times at which the node crosses faces. They only order several hits.
void find_entries(const Step& step, const SlaveNode& node, std::vector<FaceHit>& hits) {
  for (FaceHit& hit : hits) {
    if (!hit.entry_is_rough) continue;
    passes_through(corners(step.master, hit.face, step.master_body.start),
                   corners(step.master, hit.face, step.master_body.end),
                   is_triangle(step.master, hit.face), node, hit, step.master.sizes[hit.face],
                   step.options.edge_tolerance);
  }
}

// Insertion sort, best first, stable: most nodes have one hit.
void sort(const Step& step, std::vector<FaceHit>& hits) {
  const double size = step.master.sizes[hits.front().face];
  for (std::size_t i = 1; i < hits.size(); ++i)
    for (std::size_t k = i; k > 0 && better(hits[k], hits[k - 1], size); --k)
      std::swap(hits[k], hits[k - 1]);
}

bool is_held(const Step& step, const FaceHit& hit) {
  return step.held->hold(
      step.master, hit.face,
      {-hit.end.normal, hit.start_gap, hit.end_gap, step.master.sizes[hit.face]});
}

// A constraint at one face also serves the adjacent faces, except in a concave corner.
void leave_out_held(const Step& step, std::vector<FaceHit>& hits) {
  const auto held = [&](const FaceHit& hit) { return is_held(step, hit); };
  const auto end = std::stable_partition(hits.begin(), hits.end(), held);
  if (end == hits.begin()) return;
  const std::vector<FaceHit> kept(hits.begin(), end);
  hits.erase(hits.begin(), end);
  std::erase_if(hits, [&](const FaceHit& hit) {
    return std::none_of(kept.begin(), kept.end(), [&](const FaceHit& by) {
      return rises_from(step.master, hit.face, by.face);
    });
  });
}

// `pairs`: all of one node.
void detect_node(const Step& step, Index slot, std::span<const NodeAndFace> pairs,
                 std::span<const PairProjection> found, PairMemory& memory, ContactList& points) {
  thread_local std::vector<FaceHit> hits;
  const SlaveNode node = node_of(step, slot, memory);
  hits.clear();
  FaceHit hit;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (meets(step, node, pairs[k].face, found[k], hit)) hits.push_back(hit);
  if (hits.empty()) return;
  if (hits.size() > 1) find_entries(step, node, hits);
  sort(step, hits);
  if (step.held != nullptr) leave_out_held(step, hits);
  if (hits.empty()) return;
  const double start_gap = hits.front().start_gap;
  // A node behind a face that it has not crossed keeps its penetration, as pushing it out would add
  // energy
  if (step.initial || (node.face < 0 && start_gap < 0))
    keep_overlap(slot, start_gap + node.lift, step.initial, memory);
  if (hits.size() > 1) blend_normals(step, node, hits);
  const std::size_t n_held = choose_holding(step, node, hits);
  for (std::size_t i = 0; i < n_held; ++i)
    add_point(step, node, hits[i], memory.offset[slot], points);
}

// Number of pairs in a batch of nodes, at least: projections of a batch fit into the first-level
// cache.
void detect_nodes(const Step& step, PairMemory& memory, ContactList& points) {
  constexpr std::size_t at_once = 128;
  thread_local std::vector<NodeAndFace> pairs;
  thread_local std::vector<PairProjection> found;
  const CandidateList& list = memory.grid.candidates;
  const Index n = static_cast<Index>(step.slave.nodes.size());
  for (Index begin = 0, end = 0; begin < n; begin = end) {
    pairs.clear();
    for (; end < n && pairs.size() < at_once; ++end)
      for (Index k = list.first[end]; k < list.first[end + 1]; ++k)
        pairs.push_back({step.slave.nodes[end], list.target[k]});
    project_pairs(step.master, step.master_body, step.slave_body, pairs, step.reach, found);
    std::size_t at = 0;
    for (Index slot = begin; slot < end; ++slot) {
      const auto count = static_cast<std::size_t>(list.first[slot + 1] - list.first[slot]);
      if (count > 0)
        detect_node(step, slot, std::span(pairs).subspan(at, count),
                    std::span(found).subspan(at, count), memory, points);
      at += count;
    }
  }
}

// Whether the two bodies are out of reach of each other. The cost does not depend on their size.
bool are_apart(const ContactBody& slave, const ContactBody& master, const ContactSurface& faces,
               bool initial, const DetectionOptions& options, const PairMemory& memory) {
  if (!std::isfinite(slave.longest_way) || !std::isfinite(master.longest_way)) return false;
  // The drift of the master is at most the longest path of its nodes
  const double reach =
      contact_reach(faces.size, slave.longest_way + 3 * master.longest_way, initial, memory);
  const double depth = std::max(memory.depth, options.late_depth * faces.extent.norm());
  const Vector3 beside = options.overhang() * (faces.extent.array() + master.longest_way);
  const Vector3 margin = beside.array() + std::max(reach, depth);
  const Box grown{master.swept.lower - margin, master.swept.upper + margin};
  return !slave.swept.meets(grown);
}

void start_search(const ContactSurface& slave, const ContactSurface& master, PairMemory& memory) {
  const Index n = static_cast<Index>(slave.nodes.size());
  start_memory(n, memory);
  if (!master.rising.empty() && memory.further_faces.empty())
    memory.further_faces.assign(PairMemory::n_further * static_cast<std::size_t>(n), -1);
}

// A node slightly outside a long face or a sharp corner may be far from it relative to the face
// size. So the margin covers the depth too.
double margin_of(double reach, const PairMemory& memory) { return std::max(reach, memory.depth); }

void find_points(const Step& step, PairMemory& memory, ContactList& list) {
  const std::size_t before = list.points.size();
  detect_nodes(step, memory, list);
  if (list.points.size() == before) forget(memory);
}

// Records initial overlap and gap for the report, of all nodes, including those left out above.
void note_closeness(const CandidateSearch& search, const DetectionOptions& options,
                    PairMemory& memory) {
  const auto standing = [](const ContactBody& body) {
    ContactBody at;
    at.start = at.end = body.start;
    at.turn = body.turn;
    return at;
  };
  ClosenessMemory once;
  const Closeness of =
      closeness(search.slave, standing(search.slave_body), search.master,
                standing(search.master_body), search.master.size, options, 0, once);
  memory.initial_overlap = std::max(memory.initial_overlap, of.depth);
  memory.initial_gap = std::min(memory.initial_gap, of.gap);
}

// Motions in a step relative to the mean motion of the master.
struct Motion {
  Vector3 drift;
  double longest = 0;
  Motion(const ContactSurface& slave, const ContactBody& slave_body, const ContactSurface& master,
         const ContactBody& master_body)
      : drift(mean_motion(master, master_body)),
        longest(largest_motion(slave, slave_body, drift) +
                largest_motion(master, master_body, drift)) {}
};

CandidateSearch search_of(const ContactSurface& slave, const ContactBody& slave_body,
                          const ContactSurface& master, const ContactBody& master_body,
                          const Motion& motion, double margin, const DetectionOptions& options) {
  const double late_depth = options.late_depth, overhang = options.overhang();
  return {slave,          master, slave_body, master_body, motion.drift,
          motion.longest, margin, late_depth, overhang};
}

}  // namespace

void detect(const ContactSurface& slave, const ContactBody& slave_body,
            const ContactSurface& master, const ContactBody& master_body, bool initial,
            const DetectionOptions& options, PairMemory& memory, ContactList& list) {
  start_search(slave, master, memory);
  if (are_apart(slave_body, master_body, master, initial, options, memory)) return forget(memory);
  const Motion motion(slave, slave_body, master, master_body);
  const double reach = contact_reach(master.size, motion.longest, initial, memory);
  const CandidateSearch search =
      search_of(slave, slave_body, master, master_body, motion, margin_of(reach, memory), options);
  update_candidates(search, nullptr, memory);
  find_points({{master, master_body, options, reach}, slave, slave_body, initial, search}, memory,
              list);
}

SearchEnds detect_both(const ContactSurface& slave, const ContactBody& slave_body,
                       const ContactSurface& master, const ContactBody& master_body, bool initial,
                       const DetectionOptions& options, PairMemory& memory, const OtherSide& other,
                       ContactList& list) {
  start_search(slave, master, memory);
  start_search(other.nodes, slave, other.back);
  if (are_apart(slave_body, master_body, master, initial, options, memory) &&
      are_apart(master_body, slave_body, slave, initial, options, other.back)) {
    for (PairMemory* of : {&memory, &other.back, &other.edges}) forget(*of);
    return {list.points.size(), list.points.size(), list.points.size()};
  }
  const Motion motion(slave, slave_body, master, master_body),
      back_motion(other.nodes, master_body, slave, slave_body);
  const double size = std::min(slave.size, master.size),
               reach = contact_reach(master.size, motion.longest, initial, memory),
               back_reach = contact_reach(slave.size, back_motion.longest, initial, other.back),
               edge_reach = contact_reach(size, motion.longest, initial, other.edges);
  const CandidateSearch search =
      search_of(slave, slave_body, master, master_body, motion, margin_of(reach, memory), options);
  const CandidateSearch back = search_of(other.nodes, master_body, slave, slave_body, back_motion,
                                         margin_of(back_reach, other.back), options);
  const FurtherSearch further{
      back, std::max(margin_of(edge_reach, other.edges), options.late_depth * size), other.back,
      other.edges};
  update_candidates(search, &further, memory);
  SearchEnds ends;
  const std::size_t first = list.points.size();
  find_points({{master, master_body, options, reach}, slave, slave_body, initial, search}, memory,
              list);
  ends.nodes = list.points.size();
  const HeldNodes held(list, first, ends.nodes, slave.nodes, 1, memory);
  Step back_step{{slave, slave_body, options, back_reach}, other.nodes, master_body, initial, back};
  if (other.only_unheld) back_step.held = &held;
  find_points(back_step, other.back, list);
  ends.back = list.points.size();
  const HeldNodes held_back(list, ends.nodes, ends.back, other.nodes.nodes, -1, other.back);
  if (options.both_sides)
    detect_edges({slave, master, slave_body, master_body, options, size, edge_reach, motion.longest,
                  initial},
                 {&held, &held_back}, other.edges, list);
  ends.edges = list.points.size();
  if (ends.edges == ends.back) forget(other.edges);
  if (initial) note_closeness(search, options, memory);
  return ends;
}

}  // namespace cbr
