// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/mortar.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "dynamics/contact/search/mortar_search.hpp"

namespace cbr {
namespace {

// A slave node with a smaller fraction of its tributary area in contact has no multiplier of its
// own. Beyond the master's rim there are more slave nodes than motions of the shared strip. Its
// shape function is added to its neighbours in the face, so that the multipliers still sum to one.
constexpr double least_share = 0.05;

// Corner j of the slave face of a segment.
struct Corner {
  Index segment = 0, slot = 0, group = -1;
  int j = 0;
};

// The corners that make one point: of one slave node, on faces of similar orientation.
struct Group {
  Index slot = 0;
  Vector3 first_normal;
  double D = 0, share = 0;  // int N_j dA; the node's tributary area of whole faces
  bool kept = false;
};

// Sums of terms by node, in the order of their first appearance.
class TermSums {
 public:
  explicit TermSums(Index n_nodes) : sums_(n_nodes, 0.0), seen_(n_nodes, 0) {}
  // Values of a face's corners and mid-side nodes.
  void add(const ContactSurface& surface, Index face, const Eigen::Matrix<double, 1, 9>& values) {
    for (int a = 0; a < (is_triangle(surface, face) ? 3 : 4); ++a)
      add(surface.faces(face, a), values[a]);
    if (!is_quadratic(surface, face)) return;
    for (int a = 0; a < 5; ++a)
      if (surface.middle(face, a) >= 0) add(surface.middle(face, a), values[4 + a]);
  }
  // Appends sign x sum / (sum of all), ascending by node, and empties it.
  void flush(Index body, double sign, std::vector<ContactTerm>& terms) {
    std::sort(nodes_.begin(), nodes_.end());
    double all = 0;
    for (const Index node : nodes_) all += sums_[node];
    for (const Index node : nodes_) {
      if (sums_[node] != 0) terms.push_back({body, node, sign * sums_[node] / all});
      sums_[node] = 0;
      seen_[node] = 0;
    }
    nodes_.clear();
  }

 private:
  void add(Index node, double value) {
    if (!seen_[node]) {
      seen_[node] = 1;
      nodes_.push_back(node);
    }
    sums_[node] += value;
  }

  std::vector<double> sums_;
  std::vector<char> seen_;
  std::vector<Index> nodes_;
};

// Corners of all segments, ascending by slot; those of one slot by descending size of their faces.
// The grouping by orientation depends on the first face and must not depend on face numbers.
std::vector<Corner> corners_by_slot(const ContactSurface& slave,
                                    const std::vector<FacePair>& pairs) {
  std::vector<Corner> corners;
  corners.reserve(4 * pairs.size());
  Index before = -1;
  std::array<Index, 4> slot{};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Index face = pairs[i].slave_face;
    const int n = n_corners(slave, face);
    for (int j = 0; j < n && face != before; ++j) slot[j] = slot_of(slave, face, j);
    before = face;
    for (int j = 0; j < n; ++j) corners.push_back({static_cast<Index>(i), slot[j], -1, j});
  }
  const auto size = [&](const Corner& corner) {  // rounded: equal sizes stay equal
    return std::round(1e9 * slave.sizes[pairs[corner.segment].slave_face] / slave.size);
  };
  std::stable_sort(corners.begin(), corners.end(), [&](const Corner& a, const Corner& b) {
    return a.slot != b.slot ? a.slot < b.slot : size(a) > size(b);
  });
  return corners;
}

// Fills Corner::group; the groups of a slot follow each other.
std::vector<Group> make_groups(const ContactSurface& slave, const std::vector<FacePair>& pairs,
                               std::vector<Corner>& corners) {
  std::vector<Group> groups;
  std::size_t first = 0;  // group of the slot
  Index face_before = -1;
  for (std::size_t c = 0; c < corners.size(); ++c) {
    Corner& corner = corners[c];
    const FacePair& pair = pairs[corner.segment];
    if (c == 0 || corners[c - 1].slot != corner.slot) {
      first = groups.size();
      face_before = -1;
    }
    std::size_t g = first;
    while (g < groups.size() && groups[g].first_normal.dot(pair.normal) < same_side) ++g;
    if (g == groups.size()) groups.push_back({corner.slot, pair.normal});
    corner.group = static_cast<Index>(g);
    groups[g].D += pair.segment.D.row(corner.j).sum();
    const double size = slave.sizes[pair.slave_face];
    if (pair.slave_face != face_before)
      groups[g].share += size * size / n_corners(slave, pair.slave_face);
    face_before = pair.slave_face;
  }
  return groups;
}

// per segment, those of its corners; -1 beyond a triangle's third
using FaceGroups = std::vector<std::array<Index, 4>>;

// Keeps groups with enough area, and at least one per face.
void choose_kept(const std::vector<FacePair>& pairs, const FaceGroups& of,
                 std::vector<Group>& groups) {
  for (Group& group : groups) group.kept = group.D >= least_share * group.share;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Index largest = of[i][0];
    bool any = false;
    for (const Index g : of[i]) {
      if (g < 0) continue;
      any = any || groups[g].kept;
      if (groups[g].D > groups[largest].D) largest = g;
    }
    if (!any) groups[largest].kept = true;
  }
}

// Distributes multipliers of dropped groups equally to the other groups of the face.
void merge_rows(const FaceGroups& of, const std::vector<Group>& groups,
                std::vector<FacePair>& pairs) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Segment& segment = pairs[i].segment;
    int n_kept = 0;
    for (const Index g : of[i]) n_kept += g >= 0 && groups[g].kept;
    for (int j = 0; j < 4; ++j) {
      if (of[i][j] < 0 || groups[of[i][j]].kept) continue;
      for (int k = 0; k < 4; ++k) {
        if (of[i][k] < 0 || !groups[of[i][k]].kept) continue;
        segment.D.row(k) += segment.D.row(j) / n_kept;
        segment.M.row(k) += segment.M.row(j) / n_kept;
      }
      segment.D.row(j).setZero();
      segment.M.row(j).setZero();
    }
  }
}

// Normal component of the last step's impulse on the point's node; 0 if it had another direction.
double pushed_along(const ContactPoint& point, const PairMemory& memory) {
  if (memory.impulse.rows() == 0) return 0;
  const auto impulse = memory.impulse.row(point.slot);
  const double along = impulse.dot(point.normal());
  return along > same_side * impulse.norm() ? along : 0;
}

// A point whose penetration has grown by `drift` since the last step.
struct Jump {
  std::size_t point = 0;
  double drift = 0, impulse = 0;  // of the last step
};

// Keeps penetrations that contact did not close, so that no step removes them at once. A node
// behind faces that it has not crossed keeps its whole penetration as overlap. A node on an edge
// has one overlap for all sides; `first`: the largest side. False: the penetration of another side
// is too large for contact. Drifts by changed weights go to `jumps`.
bool keep_overlaps(const MortarStep& step, const ContactPoint& point, double start, bool first,
                   std::size_t place, PairMemory& memory, std::vector<Jump>& jumps) {
  if (first && (step.initial || (memory.face[point.slot] < 0 && start < memory.rest))) {
    keep_overlap(point.slot, start, step.initial, memory);
    return true;
  }
  const double drift = std::min(memory.rest, memory.offset[point.slot]) - start;
  if (memory.lets_jump || !(drift > 0)) return true;
  if (!first && drift > step.options.late_depth * step.master.sizes[point.face]) return false;
  jumps.push_back({place, drift, pushed_along(point, memory)});
  return true;
}

// The weights of the points change as the faces slide, and with them the gaps. Impulses correct
// only a part of that drift: they return the energy that such changes have taken, estimated with
// the last step's impulses. All points have the same fraction. The rest stays as overlap, from
// which gaps then count.
void settle_overlaps(const MortarStep& step, const std::vector<Jump>& jumps, std::size_t first,
                     PairMemory& memory, ContactList& list) {
  const double most = step.options.drift_share * step.motion;
  double asked = 0;
  for (const Jump& jump : jumps) asked += jump.impulse * std::min(jump.drift, most);
  const double share = asked > 0 ? std::clamp(memory.drift_taken / asked, 0.0, 1.0) : 0.0;
  for (const Jump& jump : jumps) {
    const ContactPoint& point = list.points[jump.point];
    const double given = jump.impulse > 0 ? share * std::min(jump.drift, most) : 0.0;
    const double left = point.start_gap + given;
    // an adjusted gap stays closed
    if (left < memory.rest) memory.offset[point.slot] = std::min(memory.offset[point.slot], left);
  }
  for (std::size_t i = first; i < list.points.size(); ++i) {
    ContactPoint& point = list.points[i];
    point.gap[0] -= memory.offset[point.slot];
    point.start_gap -= memory.offset[point.slot];
  }
}

// Appends the point of corners `of`, gaps without overlaps yet; nothing if it is out of reach.
void add_point(const MortarStep& step, const std::vector<FacePair>& pairs,
               const std::vector<const Corner*>& of, Index slot, bool is_first,
               TermSums& slave_sums, TermSums& master_sums, PairMemory& memory,
               std::vector<Jump>& jumps, ContactList& list) {
  ContactPoint point;
  point.slot = slot;
  point.first_term = static_cast<Index>(list.terms.size());
  Vector3 area_vector = Vector3::Zero();
  double largest = 0;
  for (const Corner* corner : of) {
    const FacePair& pair = pairs[corner->segment];
    const double D = pair.segment.D.row(corner->j).sum();
    slave_sums.add(step.slave, pair.slave_face, pair.segment.D.row(corner->j));
    master_sums.add(step.master, pair.master_face, pair.segment.M.row(corner->j));
    area_vector += D / pair.normal.dot(pair.master_normal) * pair.master_normal;
    point.area += D;
    if (D > largest) {
      largest = D;
      point.face = pair.master_face;
    }
  }
  slave_sums.flush(step.slave.body, 1, list.terms);
  point.n_slave_terms = static_cast<Index>(list.terms.size()) - point.first_term;
  master_sums.flush(step.master.body, -1, list.terms);
  const Vector3 normal = -area_vector.stableNormalized();
  const auto gap = [&](const Points& slave, const Points& master) {
    Vector3 r = Vector3::Zero();
    for (Index t = point.first_term; t < static_cast<Index>(list.terms.size()); ++t) {
      const ContactTerm& term = list.terms[t];
      r += term.coefficient *
           (t < point.first_term + point.n_slave_terms ? slave : master).row(term.node).transpose();
    }
    return normal.dot(r);
  };
  const double end = gap(step.slave_body.end, step.master_body.end);
  if (end > step.reach || !(point.area > 0)) {
    list.terms.resize(point.first_term);
    return;
  }
  const double start = gap(step.slave_body.start, step.master_body.start);
  point.frame = contact_frame(normal);
  if (!keep_overlaps(step, point, start, is_first, list.points.size(), memory, jumps)) {
    list.terms.resize(point.first_term);
    return;
  }
  point.gap[0] = end;
  point.start_gap = start;
  point.n_terms = static_cast<Index>(list.terms.size()) - point.first_term;
  list.points.push_back(point);
}

}  // namespace

void detect_mortar(const ContactSurface& slave, const ContactBody& slave_body,
                   const ContactSurface& master, const ContactBody& master_body, bool initial,
                   const DetectionOptions& options, PairMemory& memory, ContactList& list) {
  start_memory(static_cast<Index>(slave.nodes.size()), memory);
  const MortarStep step =
      mortar_step(slave, slave_body, master, master_body, initial, options, memory);
  std::vector<FacePair> pairs = find_face_pairs(step, memory);
  std::vector<Corner> corners = corners_by_slot(slave, pairs);
  std::vector<Group> groups = make_groups(slave, pairs, corners);
  FaceGroups of_faces(pairs.size(), {-1, -1, -1, -1});
  for (const Corner& corner : corners) of_faces[corner.segment][corner.j] = corner.group;
  choose_kept(pairs, of_faces, groups);
  merge_rows(of_faces, groups, pairs);
  const std::size_t before = list.points.size();
  std::vector<Jump> jumps;
  TermSums slave_sums(slave_body.end.rows()), master_sums(master_body.end.rows());
  std::vector<std::vector<const Corner*>> of(1);
  for (std::size_t first = 0, last = 0; first < corners.size(); first = last) {
    const Index slot = corners[first].slot, g0 = corners[first].group;
    std::vector<Index> order;  // groups of the slot, largest first: it owns the offset
    for (last = first; last < corners.size() && corners[last].slot == slot; ++last) {
      const std::size_t g = corners[last].group - g0;
      if (of.size() <= g) of.resize(g + 1);
      if (of[g].empty() && groups[corners[last].group].kept) order.push_back(static_cast<Index>(g));
      of[g].push_back(&corners[last]);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return groups[g0 + a].D > groups[g0 + b].D; });
    for (const Index g : order)
      add_point(step, pairs, of[g], slot, g == order.front(), slave_sums, master_sums, memory,
                jumps, list);
    for (auto& group : of) group.clear();
  }
  if (list.points.size() == before) return forget(memory);
  settle_overlaps(step, jumps, before, memory, list);
}

}  // namespace cbr
