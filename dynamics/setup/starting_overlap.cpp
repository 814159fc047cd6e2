// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/starting_overlap.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "dynamics/contact/broad_phase.hpp"

namespace cbr {
namespace {

// Comparisons of a node and a face for one pair: a tenth of a second.
constexpr double most_comparisons = 5e6;
// Of a face: less is round-off.
constexpr double least_depth = 1e-6;

using Triangle = std::array<Vector3, 3>;

// Nearest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5, by way of the edges).
Vector3 nearest_point(const Triangle& t, const Vector3& x) {
  const Vector3 a = t[1] - t[0], b = t[2] - t[0], r = x - t[0];
  const double aa = a.dot(a), ab = a.dot(b), bb = b.dot(b), ra = r.dot(a), rb = r.dot(b), det = aa * bb - ab * ab;
  if (det > 0) {
    const double u = (bb * ra - ab * rb) / det, v = (aa * rb - ab * ra) / det;
    if (u >= 0 && v >= 0 && u + v <= 1) return t[0] + u * a + v * b;
  }
  Vector3 nearest = t[0];
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 edge = t[(i + 1) % 3] - t[i];
    const double length = edge.squaredNorm();
    const Vector3 p = t[i] + (length > 0 ? std::clamp((x - t[i]).dot(edge) / length, 0.0, 1.0) : 0.0) * edge;
    if ((p - x).squaredNorm() < (nearest - x).squaredNorm()) nearest = p;
  }
  return nearest;
}

struct Found {
  double depth = 0, size = 0;  // of the face
  Index slot = -1;             // contact node of the slave's body
};

// How deep x is straight behind the nearest of the faces; 0 where it is not.
Found depth_of(const Vector3& x, const ContactSurface& master, const Points& points) {
  Found found;
  double nearest = HUGE_VAL;
  for (Index f = 0; f < master.faces.rows(); ++f) {
    const auto corner = [&](Index i) { return Vector3(points.row(master.faces(f, i))); };
    const Index n = is_triangle(master, f) ? 1 : 2;
    for (Index half = 0; half < n; ++half) {
      const Triangle t{corner(0), corner(1 + half), corner(2 + half)};
      const Vector3 away = x - nearest_point(t, x);
      const double distance = away.norm();
      if (distance >= nearest) continue;
      nearest = distance;
      const Vector3 normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
      const bool straight_behind = away.dot(normal) <= -(1 - 1e-6) * distance;
      found.depth = straight_behind ? distance : 0;
      found.size = master.sizes[f];
    }
  }
  return found;
}

Box extents(const Body& body) {
  const Points& x = body.reference_positions();
  return {x.colwise().minCoeff().transpose(), x.colwise().maxCoeff().transpose()};
}

bool is_within(const Box& box, const Vector3& x) {
  const Vector3 margin = 1e-9 * (box.upper - box.lower);
  return ((x - box.lower + margin).array() >= 0).all() && ((box.upper + margin - x).array() >= 0).all();
}

// The deepest node of the pair.
Found deepest(const ContactPair& pair, const Simulation& sim, const std::vector<Box>& boxes) {
  const ContactNodes &slave = sim.contact_nodes[pair.slave.body], &master = sim.contact_nodes[pair.master.body];
  const Points& x = sim.bodies[slave.body]->reference_positions();
  std::vector<Index> inside;
  for (const Index slot : pair.slave.nodes)
    if (is_within(boxes[master.body], x.row(slave.nodes[slot]).transpose())) inside.push_back(slot);
  Found worst;
  if (inside.empty()) return worst;
  const Points points = sim.bodies[master.body]->reference_positions()(master.nodes, Eigen::all);
  const double all = static_cast<double>(inside.size()) * static_cast<double>(pair.master.faces.rows());
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::ceil(all / most_comparisons)));
  for (std::size_t i = 0; i < inside.size(); i += stride) {
    Found found = depth_of(x.row(slave.nodes[inside[i]]).transpose(), pair.master, points);
    found.slot = inside[i];
    if (found.depth > worst.depth) worst = found;
  }
  return worst;
}

void warn(const ContactPair& pair, const Found& found, const BuiltScene& built, Report& report) {
  const ContactNodes& slave = built.simulation.contact_nodes[pair.slave.body];
  const Geometry& geometry = *built.instances[slave.body].geometry;
  std::ostringstream text;
  text.precision(3);
  text << pair.source.text() << ": contact " << pair.name << ": node id "
       << geometry.node_ids[static_cast<std::size_t>(slave.nodes[found.slot])] << " of " << pair.slave.name << " starts "
       << found.depth << " behind the faces of " << pair.master.name << ", more than a face (" << found.size
       << "): contact takes it for one on the other side and will not push it out; look at the positions of the instances";
  report.warning(text.str());
}

}  // namespace

void look_for_overlaps(BuiltScene& built, Report& report) {
  Simulation& sim = built.simulation;
  std::vector<Box> boxes;
  for (const auto& body : sim.bodies) boxes.push_back(extents(*body));
  for (ContactPair& pair : sim.pairs) {
    if (pair.wall || pair.law.law == ContactLaw::tied) continue;
    const Index a = sim.contact_nodes[pair.slave.body].body, b = sim.contact_nodes[pair.master.body].body;
    if (a == b || !boxes[a].meets(boxes[b])) continue;
    const Found found = deepest(pair, sim, boxes);
    if (found.depth > found.size) {
      warn(pair, found, built, report);
    } else if (found.depth > least_depth * found.size && sim.bodies[a]->at_rest() && sim.bodies[b]->at_rest()) {
      pair.memory.initial_overlap = std::max(pair.memory.initial_overlap, found.depth);
    }
  }
}

}  // namespace cbr
