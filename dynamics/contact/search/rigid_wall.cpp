// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/rigid_wall.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace cbr {
namespace {

using Kind = WallOptions::Kind;

// From the sphere's centre, or perpendicular from the cylinder's axis, to x.
Vector3 radial(const WallOptions& wall, const Vector3& x) {
  const Vector3 d = x - wall.point;
  return wall.kind == Kind::cylinder ? Vector3(d - d.dot(wall.direction) * wall.direction) : d;
}

// Time during which all nodes stay beyond the plane direction . x = level.
double time_beyond(const MotionBound& b, const Vector3& direction, double level) {
  double gap = -level, speed = 0, growth = 0, acceleration = 0;
  for (int c = 0; c < 3; ++c) {
    const double d = direction[c];
    gap += d * (d > 0 ? b.lower[c] : b.upper[c]);
    speed += d * (d > 0 ? b.lower_speed[c] : b.upper_speed[c]);
    growth += std::abs(d) * b.growth[c];
    acceleration += std::abs(d) * b.acceleration[c];
  }
  return first_root(gap, speed, growth, acceleration);
}

// The shortest radial vector in the box: a convex problem, solved by coordinate descent (one sweep
// for a sphere).
Vector3 nearest_radial(const WallOptions& wall, const Vector3& lower, const Vector3& upper) {
  Vector3 x = 0.5 * (lower + upper);
  for (int sweep = 0; sweep < 20; ++sweep) {
    const Vector3 before = x;
    for (int c = 0; c < 3; ++c) {
      const double h = wall.kind == Kind::cylinder ? 1 - wall.direction[c] * wall.direction[c] : 1;
      if (h > 1e-12) x[c] = std::clamp(x[c] - radial(wall, x)[c] / h, lower[c], upper[c]);
    }
    if ((x - before).cwiseAbs().maxCoeff() <= 1e-9 * (upper - lower).maxCoeff()) break;
  }
  return radial(wall, x);
}

double farthest_radius(const WallOptions& wall, const Vector3& lower, const Vector3& upper) {
  double farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 x(corner & 1 ? upper[0] : lower[0], corner & 2 ? upper[1] : lower[1],
                    corner & 4 ? upper[2] : lower[2]);
    farthest = std::max(farthest, radial(wall, x).norm());
  }
  return farthest;
}

// Time until the nodes can reach a plane between their box and the wall.
double time_outside(const WallOptions& wall, const MotionBound& b, double margin) {
  const Vector3 r = nearest_radial(wall, b.lower, b.upper);
  const double distance = r.norm();
  if (!(distance > wall.radius + margin)) return 0;
  const Vector3 direction = r / distance;
  return time_beyond(b, direction, direction.dot(wall.point) + wall.radius + margin);
}

// Time during which the swept box of the nodes stays inside. Bounds are convex in time, so that
// both ends of an interval bound it.
double time_inside(const WallOptions& wall, const MotionBound& b, double margin) {
  const auto is_free = [&](double t) {
    const MotionBound end = later(b, t);
    return farthest_radius(wall, b.lower.cwiseMin(end.lower), b.upper.cwiseMax(end.upper)) <
           wall.radius - margin;
  };
  if (!is_free(0)) return 0;
  const double speed =
      std::max(b.lower_speed.cwiseAbs().maxCoeff(), b.upper_speed.cwiseAbs().maxCoeff()) +
      b.growth.maxCoeff();
  double low = 0, high = HUGE_VAL;  // the distance of two inside nodes is bounded by this
  const double way = 2 * wall.radius + margin;
  if (speed > 0) high = way / speed;
  if (b.acceleration.maxCoeff() > 0)
    high = std::min(high, std::sqrt(2 * way / b.acceleration.maxCoeff()));
  if (!std::isfinite(high) || is_free(high)) return high;
  for (int halving = 0; halving < 20; ++halving) {
    const double middle = 0.5 * (low + high);
    (is_free(middle) ? low : high) = middle;
  }
  return low;
}

// Nodes at these distances from a plane, of which some are within `reach`: those that have a point,
// so that rows of contact stand while nodes at the rim come and go.
void choose_standing(const Vector& distance, double reach, double standing_reach,
                     std::vector<char>& has) {
  has.resize(static_cast<std::size_t>(distance.size()), 0);
  const auto is_new = [&](Index slot) { return distance[slot] <= reach && has[slot] == 0; };
  Index slot = 0;
  while (slot < distance.size() && !is_new(slot)) ++slot;
  if (slot == distance.size()) return;
  for (slot = 0; slot < distance.size(); ++slot)
    has[slot] = distance[slot] <= reach + standing_reach;
}

}  // namespace

RigidWall::RigidWall(const WallOptions& options) : options_(options) {
  options_.direction = options.direction.stableNormalized();
}

double RigidWall::bulge(double size) const {
  if (is_plane() || options_.inside) return 0;
  // Half of the diagonal, or of the width along a cylinder's axis
  const double half = options_.kind == WallOptions::Kind::sphere ? size / std::sqrt(2.0) : size / 2,
               R = options_.radius;
  return half < R ? R - std::sqrt(R * R - half * half) : HUGE_VAL;
}

double RigidWall::distance(const Vector3& x) const {
  if (options_.kind == Kind::plane) return options_.direction.dot(x - options_.point);
  const double beyond = radial(options_, x).norm() - options_.radius;
  return options_.inside ? -beyond : beyond;
}

Vector3 RigidWall::normal(const Vector3& x) const {
  if (options_.kind == Kind::plane) return options_.direction;
  Vector3 r = radial(options_, x);
  if (!(r.norm() > 1e-14 * options_.radius))
    r = options_.kind == Kind::cylinder ? options_.direction.unitOrthogonal()
                                        : Vector3(Vector3::UnitZ());
  return (options_.inside ? -1.0 : 1.0) * r.normalized();
}

double RigidWall::time_apart(const MotionBound& bound, double margin) const {
  if (options_.kind == Kind::plane)
    return time_beyond(bound, options_.direction, options_.direction.dot(options_.point) + margin);
  double t = 0;
  // Each bound holds for a limited time, after which a new one is computed
  for (int advance = 0; advance < 12; ++advance) {
    const MotionBound b = later(bound, t);
    const double more =
        options_.inside ? time_inside(options_, b, margin) : time_outside(options_, b, margin);
    t += more;
    if (!std::isfinite(t) || more <= 1e-3 * t) break;
  }
  return t;
}

Vector3 RigidWall::entry(const Vector3& x0, const Vector3& x1) const {
  if (options_.kind == Kind::plane || options_.inside) return x1;
  if (distance(x0) <= 0) return x0;
  // |r0 + t d| = R
  const Vector3 r0 = radial(options_, x0), d = radial(options_, x1) - r0;
  const double a = d.squaredNorm(), b = r0.dot(d),
               c = r0.squaredNorm() - options_.radius * options_.radius;
  const double discriminant = b * b - a * c;
  if (b >= 0 || discriminant < 0) return x1;
  const double t = c / (-b + std::sqrt(discriminant));
  return t < 1 ? Vector3(x0 + t * (x1 - x0)) : x1;
}

void detect_wall(const ContactSurface& slave, const ContactBody& slave_body, const RigidWall& wall,
                 bool initial, double standing_reach, PairMemory& memory, ContactList& list) {
  const Index n = static_cast<Index>(slave.nodes.size());
  start_memory(n, memory);
  const Vector3 &from = wall.shift().start, &to = wall.shift().end;
  if (std::isfinite(slave_body.longest_way)) {
    const Vector3 still = Vector3::Zero();
    const MotionBound swept{slave_body.swept.lower - from.cwiseMax(to),
                            slave_body.swept.upper - from.cwiseMin(to),
                            still,
                            still,
                            still,
                            still};
    const double way = slave_body.longest_way + (to - from).norm();
    if (wall.time_apart(swept, contact_reach(slave.size, way, initial, memory)) > 0)
      return forget(memory);
  }
  double way2 = 0;
  for (const Index node : slave.nodes)
    way2 = std::max(
        way2, ((slave_body.end.row(node) - slave_body.start.row(node)).transpose() - (to - from))
                  .squaredNorm());
  const double reach = contact_reach(slave.size, std::sqrt(way2), initial, memory);
  const bool stands = standing_reach > 0 && wall.is_plane() && !initial;
  Vector distance;
  if (stands) {
    distance.resize(n);
    for (Index slot = 0; slot < n; ++slot)
      distance[slot] = wall.distance(slave_body.end.row(slave.nodes[slot]).transpose() - to);
    if (!(distance.minCoeff() <= reach)) return;
    choose_standing(distance, reach, standing_reach, memory.standing.has);
  }
  list.points.reserve(list.points.size() + slave.nodes.size());
  Matrix3 frame = contact_frame(wall.normal(Vector3::Zero()));  // of planes that of all nodes
  for (Index slot = 0; slot < n; ++slot) {
    if (stands && memory.standing.has[slot] == 0) continue;
    const Vector3 x0 = slave_body.start.row(slave.nodes[slot]).transpose() - from;
    const Vector3 x1 = slave_body.end.row(slave.nodes[slot]).transpose() - to;
    const double start = wall.distance(x0);
    double end = stands ? distance[slot] : wall.distance(x1);
    Vector3 normal = wall.normal(x1);
    const Vector3 entry = wall.entry(x0, x1), entry_normal = wall.normal(entry),
                  start_normal = wall.normal(x0);
    if (entry_normal.dot(normal) < same_side) {
      normal = entry_normal;
      end = wall.distance(entry) + normal.dot(x1 - entry);
    } else if (memory.face[slot] >= 0 && start_normal.dot(normal) >= same_side) {
      normal = start_normal;  // as for a node that touches a face: touch_where_it_is()
      end = start + normal.dot(x1 - x0);
    }
    if (end > reach && !stands) continue;
    if (initial || (memory.face[slot] < 0 && start < memory.rest))
      keep_overlap(slot, start, initial, memory);
    ContactPoint point;
    if (!wall.is_plane()) frame = contact_frame(normal);
    point.frame = frame;
    point.gap[0] = end - memory.offset[slot];
    point.start_gap = start - memory.offset[slot];
    point.area = facing_area(slave, slot, slave_body, point.normal());
    point.slot = slot;
    point.first_term = static_cast<Index>(list.terms.size());
    point.n_terms = 1;
    list.terms.push_back({slave.body, slave.nodes[slot], 1});
    list.points.push_back(point);
  }
}

}  // namespace cbr
