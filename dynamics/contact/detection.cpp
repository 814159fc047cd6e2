// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/detection.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <span>

#include "dynamics/contact/face_slabs.hpp"
#include "dynamics/contact/surface_geometry.hpp"

namespace cbr {
namespace {

// Slabs of the master faces in this step, each made when a node first asks for it.
class SlabCache {
 public:
  void start(Index n_faces) {
    slabs_.resize(static_cast<std::size_t>(n_faces));
    is_made_.assign(static_cast<std::size_t>(n_faces), 0);
  }
  const FaceSlab& of(const ContactSurface& master, const ContactBody& body, Index face, double edge) {
    const auto f = static_cast<std::size_t>(face);
    if (!is_made_[f]) {
      slabs_[f] = face_slab(corners(master, face, body.start), corners(master, face, body.end), is_triangle(master, face), edge);
      is_made_[f] = 1;
    }
    return slabs_[f];
  }

 private:
  std::vector<FaceSlab> slabs_;
  std::vector<char> is_made_;
};

struct Step {
  const ContactSurface& slave;
  const ContactBody& slave_body;
  const ContactSurface& master;
  const ContactBody& master_body;
  const DetectionOptions& options;
  bool initial;
  double reach;   // gaps up to this are candidates
  Vector3 drift;  // mean motion of the master surface: boxes are swept by relative motion only
  SlabCache& slabs;
};

struct Hit {
  Projection end;
  double start_gap = 0, end_gap = 0;  // distances, counted from where an adjusted gap is closed
  // When the node went through the face, as a share of the step; not above 0: it was behind it at the start, by this share of the
  // face's size. The last face that a node goes through is the one by which it enters a convex body.
  double entry = 0;
  // How far the node is off the face now, as a share of the face's size, not above 0: over it; of a face that rises from another:
  // the foot of the slope beside the node
  double outside = 0;
  bool over_now = false, over_at_end = false, nearly_over = false;
  bool right_over_at_end = false;  // not only within the tolerance of what was touched before
  bool same = false;               // it is the face that the node touched in the last step
  bool follows = false;            // looks the same way as the face that the node touched in the last step
  Index face = 0;
};

// What is known of a node from the steps before.
struct Node {
  Index slot = 0;
  Vector3 start, end;
  Index face = -1;  // touched in the last step, -1: none; at the start of this one it looks along `normal`
  Vector3 normal = Vector3::Zero();
  Vector3 known_normal = Vector3::Zero();  // of the face touched last since the bodies were apart; zero: none
  std::span<const Index> further;          // more faces that were touched in the last step, -1 behind the last
  double lift = 0;                         // an adjusted gap
};

Box swept(const Vector3& start, const Vector3& end) { return {start.cwiseMin(end), start.cwiseMax(end)}; }

void fill_boxes(const Step& step, PairMemory& memory) {
  memory.node_boxes.resize(step.slave.nodes.size());
  for (std::size_t i = 0; i < step.slave.nodes.size(); ++i) {
    const Index node = step.slave.nodes[i];
    memory.node_boxes[i] =
        swept(step.slave_body.start.row(node).transpose() + step.drift, step.slave_body.end.row(node).transpose());
  }
  const Index n_faces = step.master.faces.rows();
  memory.face_boxes.resize(n_faces);
  for (Index f = 0; f < n_faces; ++f) {
    Box box{Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
    for (int a = 0; a < 4; ++a) {
      const Index node = step.master.faces(f, a);
      const Box corner =
          swept(step.master_body.start.row(node).transpose() + step.drift, step.master_body.end.row(node).transpose());
      box.lower = box.lower.cwiseMin(corner.lower), box.upper = box.upper.cwiseMax(corner.upper);
    }
    // A node off the edge of a long face, or beyond a sharp corner, by a share of the face may be far from it beside its size
    const double depth = std::max(memory.depth, step.options.late_depth * step.master.sizes[f]);
    const Vector3 margin = Vector3::Constant(std::max(step.reach, depth)) + step.options.overhang() * (box.upper - box.lower);
    memory.face_boxes[f] = {box.lower - margin, box.upper + margin};
  }
}

// Whether a node that is behind a face at the start of the step is to be held by it. Beside an edge of a body a node is behind the
// faces of both sides: the one that it neither touched nor lies under is not to push it out.
bool held_from_behind(const Step& step, const Projection& before, const Hit& hit, double size, double edge) {
  const double depth = -hit.start_gap;
  if (hit.follows) return depth <= size && (before.outside <= edge || hit.over_at_end);
  if (step.initial) return depth <= size && before.outside <= edge;
  if (depth <= step.options.kept_depth * size) return before.outside <= edge;
  return depth <= step.options.late_depth * size && before.outside <= 1e-9;
}

// A node that touches is held along the normal and at the foot that it has now. The prediction knows no impulses of this step: it
// is off by what they do, most of all for the shortest waves, and normals that lean with it feed them (two balls pressed together
// at 0.9 of the critical step had a hundred times their energy after one Hertz contact).
void touch_where_it_is(const Projection& now, const FaceCorners& end, const Vector3& x_end, Projection& point) {
  point.normal = now.normal, point.weights = now.weights;
  Vector3 foot = Vector3::Zero();
  for (int a = 0; a < 4; ++a) foot += now.weights[a] * end[a];
  point.distance = now.normal.dot(x_end - foot);
}

// Whether it is over the moving face when it goes through; the time of that is found by regula falsi, so that a ridge between two
// faces has no gap.
bool passes_through(const FaceCorners& start, const FaceCorners& end, bool triangle, const Node& node, Hit& hit, double size,
                    double edge) {
  double t0 = 0, t1 = 1, d0 = hit.start_gap, d1 = hit.end_gap, outside = 0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    const double t = t0 + (t1 - t0) * d0 / (d0 - d1);
    FaceCorners at;
    for (int a = 0; a < 4; ++a) at[a] = (1 - t) * start[a] + t * end[a];
    const Projection p = project(at, triangle, (1 - t) * node.start + t * node.end);
    const double d = p.distance - node.lift;
    hit.entry = t, outside = p.outside;
    if (std::abs(d) <= 1e-9 * size) break;
    (d > 0 ? t0 : t1) = t, (d > 0 ? d0 : d1) = d;
  }
  return outside <= edge;
}

// Whether the node came through the face during the step, or touches or nears it; fills `hit`.
bool meets(const Step& step, const Node& node, Index face, Hit& hit) {
  const FaceSlab& slab = step.slabs.of(step.master, step.master_body, face, step.options.edge_tolerance);
  if (is_beside(slab, node.start, node.end)) return false;
  const bool triangle = is_triangle(step.master, face);
  const double size = step.master.sizes[face];
  const FaceCorners end = corners(step.master, face, step.master_body.end);
  hit.face = face;
  hit.end = project(end, triangle, node.end);
  if (!(size > 0) || hit.end.normal.isZero() || hit.end.distance > step.reach) return false;
  const FaceCorners start = corners(step.master, face, step.master_body.start);
  const Projection before = project(start, triangle, node.start);
  hit.start_gap = before.distance - node.lift;
  const bool known = before.normal.dot(node.known_normal) >= same_side;
  const double edge = known ? step.options.edge_tolerance : step.options.new_edge_tolerance;
  hit.outside = before.outside;
  hit.over_now = before.outside <= step.options.new_edge_tolerance;
  hit.over_at_end = hit.end.outside <= edge;
  hit.right_over_at_end = hit.end.outside <= step.options.new_edge_tolerance;
  hit.nearly_over = hit.end.outside <= step.options.edge_tolerance;
  hit.same = node.face == face;
  hit.follows = node.face >= 0 && before.normal.dot(node.normal) >= same_side;
  if (hit.follows && before.outside <= edge) touch_where_it_is(before, end, node.end, hit.end);
  hit.end_gap = hit.end.distance - node.lift;
  hit.entry = hit.start_gap / size;
  if (hit.start_gap <= 0) return held_from_behind(step, before, hit, size, edge) && (hit.end_gap < 0 || hit.over_at_end);
  hit.entry = 1;
  if (hit.end_gap >= 0) return hit.over_at_end;
  return passes_through(start, end, triangle, node, hit, size, edge);
}

// Which face holds a node first: the one that it touches, until it is off its edge and over the next one. Entries are rounded, so
// that faces of one plane are told apart by what they are at the end.
bool better(const Hit& a, const Hit& b) {
  if (a.over_at_end != b.over_at_end) return a.over_at_end;
  if (a.follows != b.follows) return a.follows;
  if (a.follows && a.over_now != b.over_now) return a.over_now;
  if (a.same != b.same) return a.same;
  // In a valley the face beside it is gone through last: a node that has come off for a step would sink into the one that it is
  // over
  if (!a.follows && a.right_over_at_end != b.right_over_at_end) return a.right_over_at_end;
  const double entry_a = std::round(1e10 * a.entry), entry_b = std::round(1e10 * b.entry);
  return entry_a != entry_b ? entry_a > entry_b : std::abs(a.end_gap) < std::abs(b.end_gap);
}

// Whether a node that `first` holds is to be held by `second` too: in a concave corner. At a convex edge a node that is behind both
// faces came in by one of them; the other then holds it only when the first does nothing against what this step does to it.
bool holds_too(const Step& step, const Hit& first, const Hit& second) {
  if (!second.nearly_over || second.end_gap >= 0 || second.end.normal.dot(first.end.normal) >= same_side) return false;
  const Vector3 between = centre(corners(step.master, second.face, step.master_body.end)) -
                          centre(corners(step.master, first.face, step.master_body.end));
  if (first.end.normal.dot(between) > 0 && second.end.normal.dot(between) < 0)
    return second.start_gap >= -step.options.kept_depth * step.master.sizes[second.face];
  return first.end_gap >= -1e-6 * step.master.sizes[first.face] && second.start_gap >= 0.5 * second.end_gap;
}

// Whether a face that rises from the one that holds the node first is to hold it too; fills `hit`. Where the first face lets the
// node go is in front of the other one or behind it whatever it came through on its way: the two hold it from when it is near both,
// and as long as it is behind both, so that nothing jumps while it goes over from the one to the other.
bool holds_from_foot(const Step& step, const Node& node, const Hit& first, Index face, Hit& hit) {
  const bool triangle = is_triangle(step.master, face);
  const double size = step.master.sizes[face];
  const FaceCorners end = corners(step.master, face, step.master_body.end);
  const Vector3 held = node.end - std::min(0.0, first.end_gap) * first.end.normal;
  const Projection ahead = project(end, triangle, held);
  if (!(size > 0) || ahead.normal.isZero()) return false;
  hit = {};
  hit.face = face;
  hit.end = project(end, triangle, node.end);
  if (std::min(ahead.distance, hit.end.distance) - node.lift > step.reach) return false;
  const FaceCorners start = corners(step.master, face, step.master_body.start);
  const Projection before = project(start, triangle, node.start);
  hit.start_gap = before.distance - node.lift;
  const auto is_this = [&](Index f) {
    return f == face || (f >= 0 && before.normal.dot(mean_normal(corners(step.master, f, step.master_body.start))) >= same_side);
  };
  const bool touched = is_this(node.face) || std::any_of(node.further.begin(), node.further.end(), is_this);
  if (-hit.start_gap > (touched ? 1 : step.options.kept_depth) * size) return false;
  // The foot of the slope beside the node: what lies beyond the slope's ends does not hold it
  const Vector3 along = ahead.normal - ahead.normal.dot(first.end.normal) * first.end.normal;
  const Vector3 foot = held - (ahead.distance / along.squaredNorm()) * along;
  const double edge = touched ? step.options.edge_tolerance : step.options.new_edge_tolerance;
  hit.outside = project(end, triangle, foot).outside;
  if (!(hit.outside <= edge)) return false;
  hit.nearly_over = hit.end.outside <= step.options.edge_tolerance;
  if (touched && before.outside <= edge) touch_where_it_is(before, end, node.end, hit.end);
  hit.end_gap = hit.end.distance - node.lift;
  return true;
}

bool rises_from(const ContactSurface& master, Index face, Index from) {
  if (master.rising.empty()) return false;
  const auto begin = master.rising.begin();
  const auto last = begin + master.rising_begin[from + 1];
  return std::find(begin + master.rising_begin[from], last, face) != last;
}

// Puts the faces that rise from the node's first one, and hold it, in the place of what was found of them. Of a slope of several
// faces the one that the foot is at comes first.
void ask_rising(const Step& step, const Node& node, std::vector<Hit>& hits) {
  const ContactSurface& master = step.master;
  const Index first = hits.front().face;
  std::erase_if(hits, [&](const Hit& hit) { return rises_from(master, hit.face, first); });
  const auto n_others = static_cast<std::ptrdiff_t>(hits.size());
  Hit hit;
  for (Index k = master.rising_begin[first]; k < master.rising_begin[first + 1]; ++k)
    if (holds_from_foot(step, node, hits.front(), master.rising[k], hit)) hits.push_back(hit);
  std::sort(hits.begin() + n_others, hits.end(), [](const Hit& a, const Hit& b) {
    const double off_a = std::round(1e6 * std::max(0.0, a.outside)), off_b = std::round(1e6 * std::max(0.0, b.outside));
    return off_a != off_b ? off_a < off_b : a.end_gap < b.end_gap;
  });
}

// Near an edge between faces that look nearly the same way a node that touches is held along a mean of their normals, which goes
// over from the one to the other as the node slides across: no jump, and no side is taken by a node on the edge itself.
void blend_normals(const Step& step, const Node& node, std::vector<Hit>& hits) {
  constexpr double nearly_same_way = 0.866;  // 30 degrees
  Hit& first = hits.front();
  Vector3 sum = first.end.normal;
  for (std::size_t i = 1; i < hits.size(); ++i) {
    const double share = 1 - std::max(0.0, hits[i].outside) / step.options.edge_tolerance;
    if (rises_from(step.master, hits[i].face, first.face)) continue;
    if (hits[i].follows && share > 0 && hits[i].end.normal.dot(first.end.normal) >= nearly_same_way)
      sum += share * hits[i].end.normal;
  }
  first.end.normal = sum.normalized();
  Vector3 foot = Vector3::Zero();
  for (int a = 0; a < 4; ++a) foot += first.end.weights[a] * step.master_body.end.row(step.master.faces(first.face, a)).transpose();
  first.end.distance = first.end.normal.dot(node.end - foot);
  first.end_gap = first.end.distance - node.lift;
}

void add_point(const Step& step, const Node& node, const Hit& hit, double offset, ContactList& list) {
  ContactPoint point;
  point.frame = contact_frame(hit.end.normal);
  point.gap[0] = hit.end_gap + node.lift - offset;
  point.start_gap = hit.start_gap + node.lift - offset;
  point.area = facing_area(step.slave, node.slot, point.normal());
  point.slot = node.slot, point.face = hit.face;
  point.first_term = static_cast<Index>(list.terms.size());
  list.terms.push_back({step.slave.body, step.slave.nodes[node.slot], 1});
  for (int a = 0; a < 4; ++a)
    if (hit.end.weights[a] != 0) list.terms.push_back({step.master.body, step.master.faces(hit.face, a), -hit.end.weights[a]});
  point.n_terms = static_cast<Index>(list.terms.size()) - point.first_term;
  list.points.push_back(point);
}

Node node_of(const Step& step, Index slot, const PairMemory& memory) {
  const Index i = step.slave.nodes[slot];
  Node node;
  node.slot = slot;
  node.start = step.slave_body.start.row(i).transpose(), node.end = step.slave_body.end.row(i).transpose();
  node.face = memory.face[slot];
  const Index known = memory.known_face[slot];
  if (known >= 0) node.known_normal = mean_normal(corners(step.master, known, step.master_body.start));
  if (node.face >= 0)
    node.normal = node.face == known ? node.known_normal : mean_normal(corners(step.master, node.face, step.master_body.start));
  node.lift = std::max(0.0, memory.offset[slot]);
  if (!memory.further_faces.empty())
    node.further =
        std::span(memory.further_faces).subspan(static_cast<std::size_t>(slot) * PairMemory::n_further, PairMemory::n_further);
  return node;
}

void detect_node(const Step& step, Index slot, PairMemory& memory, std::vector<Hit>& hits, ContactList& points) {
  const CandidateList& list = memory.grid.candidates;
  if (list.first[slot] == list.first[slot + 1]) return;
  const Node node = node_of(step, slot, memory);
  hits.clear();
  Hit hit;
  for (Index k = list.first[slot]; k < list.first[slot + 1]; ++k)
    if (meets(step, node, list.target[k], hit)) hits.push_back(hit);
  if (hits.empty()) return;
  std::stable_sort(hits.begin(), hits.end(), better);
  const double start_gap = hits.front().start_gap;
  // Found behind a face that it has not come through: left where it is, not thrown out
  if (step.initial || (node.face < 0 && start_gap < 0)) keep_overlap(slot, start_gap + node.lift, step.initial, memory);
  if (hits.front().follows && hits.size() > 1) blend_normals(step, node, hits);
  if (!step.master.rising.empty()) ask_rising(step, node, hits);
  std::size_t n_held = 0;  // the hits that hold come first
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const auto also = [&](const Hit& first) {
      return rises_from(step.master, hits[i].face, first.face) || holds_too(step, first, hits[i]);
    };
    if (!std::all_of(hits.begin(), hits.begin() + static_cast<std::ptrdiff_t>(n_held), also)) continue;
    add_point(step, node, hits[i], memory.offset[slot], points);
    std::swap(hits[n_held++], hits[i]);
  }
}

// Whether nothing of the two bodies can be within reach of each other; costs nothing that grows with them.
bool are_apart(const ContactBody& slave, const ContactBody& master, const ContactSurface& faces, bool initial,
               const DetectionOptions& options, const PairMemory& memory) {
  if (!std::isfinite(slave.longest_way) || !std::isfinite(master.longest_way)) return false;
  // The drift of the master is one of its nodes' ways at most
  const double reach = contact_reach(faces.size, slave.longest_way + 3 * master.longest_way, initial, memory);
  const double depth = std::max(memory.depth, options.late_depth * faces.extent.norm());
  const Vector3 beside = options.overhang() * (faces.extent.array() + master.longest_way);
  const Vector3 margin = beside.array() + std::max(reach, depth);
  const Box grown{master.swept.lower - margin, master.swept.upper + margin};
  return !slave.swept.meets(grown);
}

}  // namespace

void detect(const ContactSurface& slave, const ContactBody& slave_body, const ContactSurface& master,
            const ContactBody& master_body, bool initial, const DetectionOptions& options, PairMemory& memory, ContactList& list) {
  const Index n = static_cast<Index>(slave.nodes.size());
  start_memory(n, memory);
  if (!master.rising.empty() && memory.further_faces.empty())
    memory.further_faces.assign(PairMemory::n_further * static_cast<std::size_t>(n), -1);
  if (are_apart(slave_body, master_body, master, initial, options, memory)) {
    forget(memory);
    return;
  }
  thread_local SlabCache slabs;
  slabs.start(master.faces.rows());
  Step step{slave, slave_body, master, master_body, options, initial, 0, mean_motion(master, master_body), slabs};
  step.reach =
      contact_reach(master.size, largest_motion(slave, slave_body, step.drift) + largest_motion(master, master_body, step.drift),
                    initial, memory);
  fill_boxes(step, memory);
  find_candidates(memory.node_boxes, memory.face_boxes, memory.grid);
  std::vector<Hit> hits;
  const std::size_t before = list.points.size();
  for (Index slot = 0; slot < n; ++slot) detect_node(step, slot, memory, hits, list);
  if (list.points.size() == before) forget(memory);
}

}  // namespace cbr
