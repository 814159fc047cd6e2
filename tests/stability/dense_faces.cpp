// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes against faces: every node with every face. Distances off a face's edge are shares of its
// size.
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/linalg/dense.hpp"
#include "tests/stability/dense_search.hpp"

namespace cbr::test {
namespace {

// how far off its edge a face holds what it has held, and what is new
constexpr double held_edge = 0.05, new_edge = 1e-3;
// how deep behind a face what is new is still caught; over it, beside it
constexpr double late_depth = 0.05, kept_depth = 1e-3;
// cosines between normals: 45 and 30 degrees
constexpr double same_way = 0.7, nearly_same_way = 0.866;
// 15 degrees: hollow edges of less are none
constexpr double nearly_flat = 0.966;

using Corners = std::array<Vector3, 4>;

// The closest point of the face's plane (bilinear map), moved into the face.
struct Foot {
  std::array<double, 4> weights{};
  Vector3 normal;
  double distance = 0, outside = 0;
};

bool is_triangle(const Corners& x) { return x[2] == x[3]; }

Foot foot_of(const std::array<double, 4>& weights, const Vector3& normal, double outside,
             const Corners& x, const Vector3& node) {
  Vector3 at = Vector3::Zero();
  for (std::size_t a = 0; a < 4; ++a) at += weights[a] * x[a];
  return {weights, normal, normal.dot(node - at), outside};
}

Foot foot_on_triangle(const Corners& x, const Vector3& node) {
  Eigen::Matrix<double, 3, 2> E;
  E << x[1] - x[0], x[2] - x[0];
  const Vector3 normal = E.col(0).cross(E.col(1)).normalized();
  const Eigen::Vector2d b =
      Eigen::Matrix2d(E.transpose() * E).inverse() * (E.transpose() * (node - x[0]));
  const double outside = -std::min({b[0], b[1], 1 - b[0] - b[1]});
  std::array<double, 4> weights{1 - b[0] - b[1], b[0], b[1], 0};
  double nearest = HUGE_VAL;
  for (std::size_t a = 0; outside > 0 && a < 3; ++a) {  // the nearest of the three sides
    const std::size_t c = (a + 1) % 3;
    const Vector3 side = x[c] - x[a];
    const double t = std::clamp(side.dot(node - x[a]) / side.squaredNorm(), 0.0, 1.0);
    const double distance = (node - x[a] - t * side).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    weights = {};
    weights[a] = 1 - t;
    weights[c] = t;
  }
  return foot_of(weights, normal, outside, x, node);
}

std::array<double, 4> bilinear(double s, double t) {
  return {(1 - s) * (1 - t) / 4, (1 + s) * (1 - t) / 4, (1 + s) * (1 + t) / 4,
          (1 - s) * (1 + t) / 4};
}

// The point, its derivatives by s and t, and by both.
struct OnQuad {
  Vector3 at = Vector3::Zero(), by_s = Vector3::Zero(), by_t = Vector3::Zero(),
          by_st = Vector3::Zero();
  OnQuad(const Corners& x, double s, double t) {
    constexpr double sign_s[] = {-1, 1, 1, -1}, sign_t[] = {-1, -1, 1, 1};
    const auto N = bilinear(s, t);
    for (std::size_t a = 0; a < 4; ++a) {
      at += N[a] * x[a];
      by_st += sign_s[a] * sign_t[a] / 4 * x[a];
      by_s += sign_s[a] * (1 + sign_t[a] * t) / 4 * x[a];
      by_t += sign_t[a] * (1 + sign_s[a] * s) / 4 * x[a];
    }
  }
};

Foot foot_on_quad(const Corners& x, const Vector3& node) {
  Eigen::Vector2d s = Eigen::Vector2d::Zero();
  for (int iteration = 0; iteration < 40; ++iteration) {
    const OnQuad p(x, s[0], s[1]);
    const Vector3 r = node - p.at;
    // Gauss-Newton to come near, then Newton
    const double mixed = iteration < 3 ? 0 : r.dot(p.by_st);
    Eigen::Matrix2d H;
    H << p.by_s.squaredNorm(), p.by_s.dot(p.by_t) - mixed, p.by_s.dot(p.by_t) - mixed,
        p.by_t.squaredNorm();
    const Eigen::Vector2d change = H.inverse() * Eigen::Vector2d(p.by_s.dot(r), p.by_t.dot(r));
    s = (s + change).cwiseMax(-3).cwiseMin(3);
    if (iteration > 3 && change.norm() < 1e-15) break;
  }
  const double outside = (s.cwiseAbs().maxCoeff() - 1) / 2;
  s = s.cwiseMax(-1).cwiseMin(1);
  const OnQuad p(x, s[0], s[1]);
  return foot_of(bilinear(s[0], s[1]), p.by_s.cross(p.by_t).normalized(), outside, x, node);
}

Foot foot_on(const Corners& x, const Vector3& node) {
  return is_triangle(x) ? foot_on_triangle(x, node) : foot_on_quad(x, node);
}

Corners corners(const std::array<Index, 4>& face, const Points& x) {
  return {x.row(face[0]).transpose(), x.row(face[1]).transpose(), x.row(face[2]).transpose(),
          x.row(face[3]).transpose()};
}

Vector3 mean_normal(const Corners& x) { return (x[2] - x[0]).cross(x[3] - x[1]).normalized(); }

Vector3 middle(const Corners& x) {
  return (x[0] + x[1] + x[2] + (is_triangle(x) ? Vector3::Zero() : x[3])) /
         (is_triangle(x) ? 3 : 4);
}

// One node and one face that meet, or may.
struct Meeting {
  Index face = 0;
  Corners end_corners{Vector3::Zero(), Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  Foot end;
  double size = 0, start_gap = 0, end_gap = 0, outside = 0;  // outside: at the start
  // when the node goes through, as a share of the step; not above 0: behind by that share of the
  // size
  double entry = 0;
  bool over_end = false, near_over_end = false, right_over_end = false;
  // the face that the node touched in the last step; one that looks the same way
  bool same = false, follows = false;
};

// What a node is and does.
struct Node {
  Vector3 start, end;
  Index face = -1;
  std::vector<Index> touched;
  // of the faces touched in the last step, and last of all
  Vector3 normal = Vector3::Zero(), known_normal = Vector3::Zero();
};

// Where a node that goes through the moving face does so, by halving.
void find_entry(const Corners& start, const Corners& end, const Node& node, double& entry,
                double& outside) {
  double low = 0, high = 1;
  for (int halving = 0; halving < 60; ++halving) {
    entry = 0.5 * (low + high);
    Corners at;
    for (std::size_t a = 0; a < 4; ++a) at[a] = (1 - entry) * start[a] + entry * end[a];
    const Foot foot = foot_on(at, (1 - entry) * node.start + entry * node.end);
    outside = foot.outside;
    (foot.distance > 0 ? low : high) = entry;
  }
}

// Whether a node that starts behind a face is to be held by it.
bool is_held_from_behind(const Meeting& m, double edge, bool initial) {
  const double depth = -m.start_gap;
  if (m.follows) return depth <= m.size && (m.outside <= edge || m.over_end);
  if (initial) return depth <= m.size && m.outside <= edge;
  if (depth <= kept_depth * m.size) return m.outside <= edge;
  return depth <= late_depth * m.size && m.outside <= 1e-9;
}

std::optional<Meeting> meeting(const DenseSurface& master, const DensePath& path, std::size_t face,
                               const Node& node, double reach, bool initial) {
  const Corners start = corners(master.faces[face], path.start),
                end = corners(master.faces[face], path.end);
  Meeting m;
  m.face = static_cast<Index>(face);
  m.size = master.sizes[face];
  m.end_corners = end;
  m.end = foot_on(end, node.end);
  if (m.end.distance > reach) return {};
  const Foot before = foot_on(start, node.start);
  m.start_gap = before.distance;
  m.outside = before.outside;
  const double edge = before.normal.dot(node.known_normal) >= same_way ? held_edge : new_edge;
  m.over_end = m.end.outside <= edge;
  m.near_over_end = m.end.outside <= held_edge;
  m.right_over_end = m.end.outside <= new_edge;
  m.same = node.face == m.face;
  m.follows = node.face >= 0 && before.normal.dot(node.normal) >= same_way;
  // What touched is held along the normal and at the foot of the start
  if (m.follows && before.outside <= edge)
    m.end = foot_of(before.weights, before.normal, m.end.outside, end, node.end);
  m.end_gap = m.end.distance;
  bool is_one = false;
  if (m.start_gap <= 0) {
    m.entry = m.start_gap / m.size;
    is_one = is_held_from_behind(m, edge, initial) && (m.end_gap < 0 || m.over_end);
  } else if (m.end_gap >= 0) {
    m.entry = 1;
    is_one = m.over_end;
  } else {
    double outside = 0;
    find_entry(start, end, node, m.entry, outside);
    is_one = outside <= edge;
  }
  return is_one ? std::optional<Meeting>(m) : std::nullopt;
}

// The face that holds a node first: the one that it touches, until it is off its edge and over
// another.
bool comes_first(const Meeting& a, const Meeting& b) {
  const bool a_over = a.outside <= new_edge, b_over = b.outside <= new_edge;
  if (a.over_end != b.over_end) return a.over_end;
  if (a.follows != b.follows) return a.follows;
  if (a.follows && a_over != b_over) return a_over;
  if (a.same != b.same) return a.same;
  if (!a.follows && a.right_over_end != b.right_over_end) return a.right_over_end;
  const double entry_a = std::round(1e10 * a.entry), entry_b = std::round(1e10 * b.entry);
  return entry_a != entry_b ? entry_a > entry_b : std::abs(a.end_gap) < std::abs(b.end_gap);
}

// A concave corner holds a node by all its faces; a convex edge by the one that it came through.
bool holds_too(const Meeting& first, const Meeting& other) {
  if (!other.near_over_end || other.end_gap >= 0 ||
      other.end.normal.dot(first.end.normal) >= same_way)
    return false;
  const Vector3 between = middle(other.end_corners) - middle(first.end_corners);
  const bool concave = first.end.normal.dot(between) > 0 && other.end.normal.dot(between) < 0;
  if (concave) return other.start_gap >= -kept_depth * other.size;
  return first.end_gap >= -1e-6 * first.size && other.start_gap >= 0.5 * other.end_gap;
}

bool is_among(const std::vector<Index>& faces, Index face) {
  return std::find(faces.begin(), faces.end(), face) != faces.end();
}

// The point nearest to the node's end that is in front of all planes, by trying which of them it
// lies on; and those planes.
struct Stand {
  Vector3 at;
  std::vector<Vector3> planes;
};
Stand stand_before(const std::vector<Meeting>& holding, const Vector3& x) {
  Stand nearest{x, {}};
  double least = HUGE_VAL;
  const std::size_t n = holding.size();
  for (std::size_t set = 0; set < (std::size_t{1} << n); ++set) {
    std::vector<std::size_t> on;
    for (std::size_t i = 0; i < n; ++i)
      if (set >> i & 1) on.push_back(i);
    if (on.size() > 3) continue;
    Matrix N(3, static_cast<Index>(on.size()));
    Vector gap(static_cast<Index>(on.size()));
    for (std::size_t i = 0; i < on.size(); ++i) {
      N.col(static_cast<Index>(i)) = holding[on[i]].end.normal;
      gap[static_cast<Index>(i)] = holding[on[i]].end_gap;
    }
    const Vector push = on.empty() ? Vector() : Vector(-Ldlt(N.transpose() * N).solve(gap));
    if (!on.empty() && !(push.minCoeff() > 0)) continue;
    const Vector3 at = on.empty() ? x : Vector3(x + N * push);
    const auto is_in_front = [&](const Meeting& m) {
      return m.end_gap + m.end.normal.dot(at - x) >= -1e-10 * m.size;
    };
    if (!std::all_of(holding.begin(), holding.end(), is_in_front) || (at - x).norm() >= least)
      continue;
    least = (at - x).norm();
    nearest.at = at;
    nearest.planes.clear();
    for (Index k = 0; k < N.cols(); ++k) nearest.planes.push_back(N.col(k));
  }
  return nearest;
}

// A face that rises from the first one: what those that hold do not let through is at the foot of
// it, or goes into it.
std::optional<Meeting> meeting_at_foot(const DenseSurface& master, const DensePath& path,
                                       Index face, const Node& node,
                                       const std::vector<Meeting>& holding, double reach) {
  const auto f = static_cast<std::size_t>(face);
  const Corners start = corners(master.faces[f], path.start),
                end = corners(master.faces[f], path.end);
  Meeting m;
  m.face = face;
  m.size = master.sizes[f];
  m.end_corners = end;
  const Stand stand = stand_before(holding, node.end);
  const Foot ahead = foot_on(end, stand.at), before = foot_on(start, node.start);
  m.end = foot_on(end, node.end);
  m.start_gap = before.distance;
  const auto is_this = [&](Index g) {
    const auto i = static_cast<std::size_t>(g);
    return g == face ||
           (!is_among(master.rising[f], g) && !is_among(master.rising[i], face) &&
            before.normal.dot(mean_normal(corners(master.faces[i], path.start))) >= nearly_flat);
  };
  const bool touched = std::any_of(node.touched.begin(), node.touched.end(), is_this);
  // Where the planes that it stands on and this one meet
  Matrix N(3, static_cast<Index>(stand.planes.size()) + 1);
  for (std::size_t i = 0; i < stand.planes.size(); ++i)
    N.col(static_cast<Index>(i)) = stand.planes[i];
  N.rightCols(1) = ahead.normal;
  Vector to = Vector::Zero(N.cols());
  to[N.cols() - 1] = -ahead.distance;
  const Vector3 move = N.transpose().completeOrthogonalDecomposition().solve(to);
  m.outside = foot_on(end, stand.at + move).outside;
  const double edge = touched ? held_edge : new_edge;
  m.near_over_end = m.end.outside <= held_edge;
  if (std::min(ahead.distance, m.end.distance) > reach || m.outside > edge) return {};
  if (-m.start_gap > (touched ? 1.0 : kept_depth) * m.size) return {};
  if (touched && before.outside <= edge)
    m.end = foot_of(before.weights, before.normal, m.end.outside, end, node.end);
  m.end_gap = m.end.distance;
  return m;
}

bool nearer_the_foot(const Meeting& a, const Meeting& b) {
  const double off_a = std::round(1e6 * std::max(0.0, a.outside)),
               off_b = std::round(1e6 * std::max(0.0, b.outside));
  return off_a != off_b ? off_a < off_b : a.end_gap < b.end_gap;
}

// `holding` has the first face, and gets those that rise from it and hold the node with it, one
// after the other, the nearest first.
void add_rising(const DenseSurface& master, const DensePath& path, const Node& node, double reach,
                std::vector<Meeting>& holding) {
  const std::vector<Index>& rising = master.rising[holding.front().face];
  const auto fits = [&](const Meeting& m) {
    return std::all_of(holding.begin(), holding.end(), [&](const Meeting& other) {
      return other.face != m.face &&
             (is_among(master.rising[other.face], m.face) || holds_too(other, m));
    });
  };
  // With `other` among those that hold, whatever it came through
  const auto beside = [&](Index face, Index other) -> std::optional<Meeting> {
    const Corners end = corners(master.faces[other], path.end);
    Meeting m;
    m.face = other;
    m.size = master.sizes[other];
    m.end_corners = end;
    m.end = foot_on(end, node.end);
    m.end_gap = m.end.distance;
    if (m.end_gap >= 0) return {};
    std::vector<Meeting> with = holding;
    with.push_back(m);
    return meeting_at_foot(master, path, face, node, with, reach);
  };
  for (;;) {
    std::vector<Meeting> found;
    for (const Index face : rising)
      if (const auto m = meeting_at_foot(master, path, face, node, holding, reach); m && fits(*m))
        found.push_back(*m);
    // Two walls in one step: each lets the node pass by the end of the other
    for (const Index face : found.empty() ? rising : std::vector<Index>())
      for (const Index other : rising)
        if (is_among(master.rising[face], other) && beside(other, face))
          if (const auto m = beside(face, other); m && fits(*m)) found.push_back(*m);
    if (found.empty()) return;
    holding.push_back(*std::min_element(found.begin(), found.end(), nearer_the_foot));
  }
}

// Near an edge between faces that look nearly the same way the normal goes over from the one to the
// other.
void blend(std::vector<Meeting>& meetings, const Node& node, const std::vector<Index>& rising) {
  Meeting& first = meetings.front();
  if (!first.follows || meetings.size() < 2) return;
  Vector3 normal = first.end.normal;
  for (std::size_t i = 1; i < meetings.size(); ++i) {
    const Meeting& m = meetings[i];
    if (is_among(rising, m.face)) continue;
    const double share = 1 - std::max(0.0, m.outside) / held_edge;
    if (m.follows && share > 0 && m.end.normal.dot(first.end.normal) >= nearly_same_way)
      normal += share * m.end.normal;
  }
  first.end = foot_of(first.end.weights, normal.normalized(), first.end.outside, first.end_corners,
                      node.end);
  first.end_gap = first.end.distance;
}

double longest_way(const DenseSurface& surface, const DensePath& path, const Vector3& drift) {
  double way = 0;
  for (const Index node : surface.nodes)
    way = std::max(way, (path.end.row(node) - path.start.row(node) - drift.transpose()).norm());
  return way;
}

}  // namespace

std::vector<DensePoint> dense_face_points(const DenseSurface& slave, const DensePath& slave_path,
                                          const DenseSurface& master, const DensePath& master_path,
                                          bool initial, DenseMemory& memory) {
  start(slave, memory);
  Vector3 drift = Vector3::Zero();
  for (const Index node : master.nodes)
    drift += (master_path.end.row(node) - master_path.start.row(node)).transpose();
  drift /= static_cast<double>(master.nodes.size());
  const double reach = dense_reach(
      master.size, longest_way(slave, slave_path, drift) + longest_way(master, master_path, drift),
      initial);
  const auto normal_of = [&](Index face) {
    return face < 0 ? Vector3(Vector3::Zero())
                    : mean_normal(corners(master.faces[face], master_path.start));
  };
  std::vector<DensePoint> points;
  for (std::size_t i = 0; i < slave.nodes.size(); ++i) {
    const Node node{slave_path.start.row(slave.nodes[i]).transpose(),
                    slave_path.end.row(slave.nodes[i]).transpose(),
                    memory.face[i],
                    memory.touched[i],
                    normal_of(memory.face[i]),
                    normal_of(memory.known_face[i])};
    std::vector<Meeting> meetings;
    for (std::size_t f = 0; f < master.faces.size(); ++f)
      if (const auto m = meeting(master, master_path, f, node, reach, initial))
        meetings.push_back(*m);
    if (meetings.empty()) continue;
    std::stable_sort(meetings.begin(), meetings.end(), comes_first);
    const double start_gap = meetings.front().start_gap;
    if (initial || (node.face < 0 && start_gap < 0)) memory.offset[i] = std::min(0.0, start_gap);
    const std::vector<Index>& rising = master.rising[meetings.front().face];
    blend(meetings, node, rising);
    std::vector<Meeting> holding{meetings.front()};
    add_rising(master, master_path, node, reach, holding);
    for (const Meeting& m : meetings) {
      const auto with = [&](const Meeting& other) {
        return other.face != m.face && holds_too(other, m);
      };
      if (std::all_of(holding.begin(), holding.end(), with)) holding.push_back(m);
    }
    for (const Meeting& m : holding) {
      DensePoint point;
      point.frame = dense_frame(m.end.normal);
      point.gap = m.end_gap - memory.offset[i];
      point.start_gap = m.start_gap - memory.offset[i];
      point.slot = static_cast<Index>(i);
      point.face = m.face;
      point.terms = {{slave.body, slave.nodes[i], 1}};
      for (std::size_t a = 0; a < 4; ++a)
        if (m.end.weights[a] != 0)
          point.terms.push_back({master.body, master.faces[m.face][a], -m.end.weights[a]});
      points.push_back(point);
    }
  }
  return points;
}

double dense_depth(const DenseSurface& slave, const DensePath& slave_path,
                   const DenseSurface& master, const DensePath& master_path) {
  constexpr double before_it = -2e-3, well_over = -0.05;
  double depth = 0;
  for (const Index node : slave.nodes)
    for (std::size_t f = 0; f < master.faces.size(); ++f) {
      const auto foot = [&](const Points& slave_x, const Points& master_x) {
        return foot_on(corners(master.faces[f], master_x), slave_x.row(node).transpose());
      };
      const Foot start = foot(slave_path.start, master_path.start),
                 end = foot(slave_path.end, master_path.end);
      if (start.distance < before_it * master.sizes[f] || start.outside > well_over ||
          end.outside > well_over)
        continue;
      depth = std::max(depth, -end.distance / master.sizes[f]);
    }
  return depth;
}

}  // namespace cbr::test
