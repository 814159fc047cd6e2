// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/mortar_search.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>


namespace cbr {
namespace {

constexpr double facing = -0.3;  // largest cosine between the normals of faces that can touch

void fill_boxes(const ContactSurface& surface, const ContactBody& body, const Vector3& drift,
                double margin, std::vector<Box>& boxes) {
  boxes.resize(surface.faces.rows());
  for (Index f = 0; f < surface.faces.rows(); ++f) {
    Box box{Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
    for (int a = 0; a < 4; ++a) {
      const Vector3 start = body.start.row(surface.faces(f, a)).transpose() + drift,
                    end = body.end.row(surface.faces(f, a)).transpose();
      box.lower = box.lower.cwiseMin(start.cwiseMin(end));
      box.upper = box.upper.cwiseMax(start.cwiseMax(end));
    }
    boxes[f] = {box.lower.array() - margin, box.upper.array() + margin};
  }
}

FaceOrder order_of(const ContactSurface& surface, Index face) {
  if (has_centre(surface, face)) return FaceOrder::biquadratic;
  return is_quadratic(surface, face) ? FaceOrder::quadratic : FaceOrder::linear;
}

// The slave face of a pair.
struct SlaveFace {
  Index face = 0;
  bool triangle = false;
  // Evaluates it at the start of the step: it touched in the last step, or the run begins
  bool at_start = false;
  FaceCorners start, end;
  Matrix3 frame;  // rows: outward normal, two tangents
  Vector3 origin;
  FlatFace flat;
  Vector3 normal() const { return frame.row(0).transpose(); }
  const FaceCorners& seen(const FaceCorners& first, const FaceCorners& last) const {
    return at_start ? first : last;
  }
};

SlaveFace slave_face(const MortarStep& step, const PairMemory& memory, Index face) {
  SlaveFace s;
  s.face = face;
  s.triangle = is_triangle(step.slave, face);
  s.at_start = step.initial;
  for (int a = 0; a < 4; ++a)
    s.at_start = s.at_start || memory.face[slot_of(step.slave, face, a)] >= 0;
  s.start = corners(step.slave, face, step.slave_body.start);
  s.end = corners(step.slave, face, step.slave_body.end);
  const FaceCorners& seen = s.seen(s.start, s.end);
  s.frame = contact_frame(mean_normal(seen));
  s.origin = centre(seen);
  s.flat = flatten(seen, s.triangle, s.frame, s.origin, true);
  s.flat.order = order_of(step.slave, face);
  return s;
}

FaceCorners between(const FaceCorners& start, const FaceCorners& end, double t) {
  FaceCorners x;
  for (int a = 0; a < 4; ++a) x[a] = (1 - t) * start[a] + t * end[a];
  return x;
}

// The shared area of the faces at time t, as a fraction of the step.
Segment segment_at(const MortarStep& step, const SlaveFace& s, Index face, double t) {
  const FaceCorners start = corners(step.master, face, step.master_body.start),
                    end = corners(step.master, face, step.master_body.end);
  const FaceCorners slave = between(s.start, s.end, t);
  const Matrix3 frame = contact_frame(mean_normal(slave));
  const Vector3 origin = centre(slave);
  FlatFace of_slave = flatten(slave, s.triangle, frame, origin, true),
           of_master = flatten(between(start, end, t), is_triangle(step.master, face), frame,
                               origin, false);
  of_slave.order = order_of(step.slave, s.face);
  of_master.order = order_of(step.master, face);
  return integrate(of_slave, of_master);
}

// Sum of the face's nodes, weighted by columns of D or M.
Vector3 weighted_sum(const CornerByNode& weights, const ContactSurface& surface, Index face,
                     const Points& points) {
  const Eigen::Matrix<double, 1, 9> w = weights.colwise().sum();
  Vector3 r = Vector3::Zero();
  for (int a = 0; a < 4; ++a) r += w[a] * points.row(surface.faces(face, a)).transpose();
  if (!is_quadratic(surface, face)) return r;
  for (int a = 0; a < 5; ++a)
    if (surface.middle(face, a) >= 0)
      r += w[4 + a] * points.row(surface.middle(face, a)).transpose();
  return r;
}

// Mean gap over the shared area, for given positions.
double mean_gap(const MortarStep& step, const FacePair& pair, const Points& slave,
                const Points& master) {
  const Vector3 r = weighted_sum(pair.segment.M, step.master, pair.master_face, master) -
                    weighted_sum(pair.segment.D, step.slave, pair.slave_face, slave);
  return pair.normal.dot(r) / pair.segment.area;
}

// Lower and upper bound of the gap by the corners, along the slave's normal.
std::array<double, 2> gap_range(const Vector3& normal, const FaceCorners& slave,
                                const FaceCorners& master) {
  double least = HUGE_VAL, most = -HUGE_VAL, lower = HUGE_VAL, upper = -HUGE_VAL;
  for (int a = 0; a < 4; ++a) {
    const double m = normal.dot(master[a]), s = normal.dot(slave[a]);
    least = std::min(least, m);
    most = std::max(most, m);
    lower = std::min(lower, s);
    upper = std::max(upper, s);
  }
  return {least - upper, most - lower};
}

bool share_a_node(const IndexTable& faces, Index f, Index g) {
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      if (faces(f, a) == faces(g, b)) return true;
  return false;
}

// Whether the last search found this pair, or the slave face with a neighbour of similar
// orientation of the master face. If so, they approached from the front, however deep they are now.
// Parts of a coarse face beside a bend are deep long before the mean gap of a node's faces closes.
// Without this test such a face would be found late and pushed out in one step.
bool were_near(const MortarStep& step, const PairMemory& memory, Index slave_face,
               Index master_face, const Vector3& master_normal) {
  const auto n = static_cast<Index>(memory.near.size() / 2);
  Index first = 0, last = n;
  while (first < last) {
    const Index middle = (first + last) / 2;
    (memory.near[2 * middle] < slave_face ? first : last) =
        memory.near[2 * middle] < slave_face ? middle + 1 : middle;
  }
  for (Index i = first; i < n && memory.near[2 * i] == slave_face; ++i) {
    const Index other = memory.near[2 * i + 1];
    if (other == master_face) return true;
    if (share_a_node(step.master.faces, master_face, other) &&
        mean_normal(corners(step.master, other, step.master_body.start)).dot(master_normal) >=
            same_side)
      return true;
  }
  return false;
}

// Largest penetration of a master face at the start of the step. A deeper one is on the other side
// of a thin body.
double allowed_depth(const MortarStep& step, const PairMemory& memory, const SlaveFace& s,
                     Index master_face, const Vector3& master_normal) {
  const double size = std::max(step.master.sizes[master_face], step.slave.sizes[s.face]);
  if (step.initial || were_near(step, memory, s.face, master_face, master_normal)) return size;
  for (int a = 0; a < 4; ++a) {
    const Index touched = memory.face[slot_of(step.slave, s.face, a)];
    if (touched < 0) continue;
    if (mean_normal(corners(step.master, touched, step.master_body.start)).dot(master_normal) >=
        same_side)
      return size;
  }
  return step.options.late_depth * size;
}

// Whether the faces share some area and can touch in the step; fills `pair`.
bool meets(const MortarStep& step, const PairMemory& memory, const SlaveFace& s, Index face,
           FacePair& pair) {
  const FaceCorners start = corners(step.master, face, step.master_body.start),
                    end = corners(step.master, face, step.master_body.end);
  const FaceCorners& seen = s.seen(start, end);
  const Vector3 master_normal = mean_normal(seen), normal = s.normal();
  if (!(master_normal.dot(normal) < facing)) return false;
  if (gap_range(normal, s.end, end)[0] > step.far) return false;
  if (gap_range(normal, s.start, start)[1] <
      -std::max(step.master.sizes[face], step.slave.sizes[s.face]))
    return false;
  const bool triangle = is_triangle(step.master, face);
  pair.slave_face = s.face;
  pair.master_face = face;
  pair.normal = normal;
  pair.master_normal = master_normal;
  FlatFace flat = flatten(seen, triangle, s.frame, s.origin, false);
  flat.order = order_of(step.master, face);
  pair.segment = integrate(s.flat, flat);
  pair.on_the_way = !(pair.segment.area > 0);
  if (pair.on_the_way) {
    const double g0 = normal.dot(centre(start) - centre(s.start)),
                 g1 = normal.dot(centre(end) - centre(s.end));
    if (!(g0 > 0 && g1 < 0)) return false;
    pair.segment = segment_at(step, s, face, g0 / (g0 - g1));
    if (!(pair.segment.area > 0)) return false;
  }
  pair.end_gap = mean_gap(step, pair, step.slave_body.end, step.master_body.end);
  pair.start_gap = mean_gap(step, pair, step.slave_body.start, step.master_body.start);
  if (pair.end_gap > step.far) return false;
  if (pair.start_gap < 0) {
    if (-pair.start_gap > allowed_depth(step, memory, s, face, master_normal)) return false;
    // Sides of bodies that overlap only from now on
    if (!s.at_start && !(segment_at(step, s, face, 0).area > 0)) return false;
  }
  if (pair.on_the_way || pair.start_gap <= 0) return true;
  // It may have come around the rim
  const double depth = step.options.late_depth * step.master.sizes[face];
  return pair.end_gap >= -depth ||
         segment_at(step, s, face, pair.start_gap / (pair.start_gap - pair.end_gap)).area > 0;
}

// The area that two master faces and the slave face share.
double common_area(const MortarStep& step, const SlaveFace& s, Index face, Index other) {
  const auto flat = [&](Index f) {
    return flatten(
        corners(step.master, f, s.at_start ? step.master_body.start : step.master_body.end),
        is_triangle(step.master, f), s.frame, s.origin, false);
  };
  const FlatFace a = flat(face), b = flat(other);
  double sum = 0;
  for (int i = 0; i < a.n_pieces; ++i)
    for (int j = 0; j < b.n_pieces; ++j)
      for (int k = 0; k < s.flat.n_pieces; ++k) {
        const Polygon both = clip(a.pieces[i].outline, b.pieces[j].outline);
        if (both.n >= 3) sum += area(clip(both, s.flat.pieces[k].outline));
      }
  return sum;
}

// Of overlapping master faces keeps only the one that the slave face meets first. pairs[first] ..
// belong to `s`.
void keep_first_layer(const MortarStep& step, const SlaveFace& s, std::size_t first,
                      std::vector<FacePair>& pairs) {
  const auto begin = pairs.begin() + static_cast<std::ptrdiff_t>(first);
  if (std::any_of(begin, pairs.end(), [](const FacePair& pair) { return !pair.on_the_way; }))
    pairs.erase(
        std::remove_if(begin, pairs.end(), [](const FacePair& pair) { return pair.on_the_way; }),
        pairs.end());
  double sum = 0, whole = 0, nearest = HUGE_VAL, farthest = -HUGE_VAL;
  for (auto pair = begin; pair != pairs.end(); ++pair) {
    sum += pair->segment.area;
    nearest = std::min(nearest, pair->start_gap);
    farthest = std::max(farthest, pair->start_gap);
  }
  for (int k = 0; k < s.flat.n_pieces; ++k) whole += s.flat.pieces[k].area;
  const bool more_than_whole = sum > whole * (1 + 1e-6);
  if (!more_than_whole && !(farthest - nearest > 1e-9 * step.slave.sizes[s.face])) return;
  std::stable_sort(begin, pairs.end(), [](const FacePair& a, const FacePair& b) {
    return std::abs(a.start_gap) < std::abs(b.start_gap);
  });
  auto last = begin;
  for (auto pair = begin; pair != pairs.end(); ++pair) {
    const auto hides = [&](const FacePair& other) {
      // Neighbours are adjacent and do not overlap
      if (!more_than_whole && share_a_node(step.master.faces, pair->master_face, other.master_face))
        return false;
      return common_area(step, s, pair->master_face, other.master_face) > 1e-3 * pair->segment.area;
    };
    if (std::none_of(begin, last, hides)) *last++ = *pair;
  }
  pairs.erase(last, pairs.end());
  std::sort(begin, last,
            [](const FacePair& a, const FacePair& b) { return a.master_face < b.master_face; });
}

// Per slave node: whether a point of it can be within reach. Cheap rejection of distant candidates.
std::vector<char> nodes_in_reach(const MortarStep& step, const CandidateList& list) {
  std::vector<char> in_reach(step.slave_body.end.rows(), 0);
  for (Index f = 0; f < step.slave.faces.rows(); ++f) {
    if (list.first[f] == list.first[f + 1]) continue;
    const FaceCorners x = corners(step.slave, f, step.slave_body.end);
    const Vector3 normal = mean_normal(x);
    const auto reaches = [&](Index face) {
      // A point's normal is at most 45 degrees off
      return same_side *
                 gap_range(normal, x, corners(step.master, face, step.master_body.end))[0] <=
             step.reach;
    };
    if (std::any_of(list.target.begin() + list.first[f], list.target.begin() + list.first[f + 1],
                    reaches))
      for (int a = 0; a < 4; ++a) in_reach[step.slave.faces(f, a)] = 1;
  }
  return in_reach;
}

}  // namespace

MortarStep mortar_step(const ContactSurface& slave, const ContactBody& slave_body,
                       const ContactSurface& master, const ContactBody& master_body, bool initial,
                       const DetectionOptions& options, const PairMemory& memory) {
  MortarStep step{slave,   slave_body, master, master_body, options,
                  initial, 0,          0,      0,           mean_motion(master, master_body)};
  step.motion = largest_motion(slave, slave_body, step.drift) +
                largest_motion(master, master_body, step.drift);
  step.reach = contact_reach(master.size, step.motion, initial, memory);
  step.far = step.reach + 0.5 * std::max(slave.size, master.size);
  return step;
}

std::vector<FacePair> find_face_pairs(const MortarStep& step, PairMemory& memory) {
  fill_boxes(step.slave, step.slave_body, step.drift, 0, memory.node_boxes);
  fill_boxes(step.master, step.master_body, step.drift, std::max(step.far, memory.depth),
             memory.face_boxes);
  find_candidates(memory.node_boxes, memory.face_boxes, memory.grid);
  const CandidateList& list = memory.grid.candidates;
  const std::vector<char> in_reach = nodes_in_reach(step, list);
  std::vector<FacePair> pairs;
  std::vector<Index> near;
  FacePair pair;
  for (Index f = 0; f < step.slave.faces.rows(); ++f) {
    if (list.first[f] == list.first[f + 1] || !(step.slave.sizes[f] > 0)) continue;
    bool any = false;
    for (int a = 0; a < 4; ++a) any = any || in_reach[step.slave.faces(f, a)];
    if (!any) continue;
    const SlaveFace s = slave_face(step, memory, f);
    const std::size_t first = pairs.size();
    for (Index k = list.first[f]; k < list.first[f + 1]; ++k)
      if (meets(step, memory, s, list.target[k], pair)) pairs.push_back(pair);
    keep_first_layer(step, s, first, pairs);
    for (std::size_t i = first; i < pairs.size(); ++i)
      near.insert(near.end(), {f, pairs[i].master_face});
  }
  memory.near = std::move(near);
  return pairs;
}

}  // namespace cbr
