// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/starting_overlap.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/setup/built/instance_elements.hpp"
#include "dynamics/setup/built/surface_distance.hpp"

namespace cbr {
namespace {

// Corners, a triangle's last one twice; `key` is equal for both sides of an interior face.
struct Face {
  std::array<Index, 4> corners, key;
};

std::vector<Face> faces_of(const Mesh& mesh) {
  std::vector<Face> faces;
  for (const Block& block : mesh.blocks) {
    if (dimension(block.type) != 3) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      for (int side = 1; side <= n_sides(block.type); ++side) {
        const std::vector<int>& local = side_nodes(block.type, side);
        const int n = n_corners(side_kind(block.type, side));
        Face face;
        for (int i = 0; i < 4; ++i)
          face.corners[i] = block.connectivity(e, local[std::min(i, n - 1)]);
        face.key = face.corners;
        std::sort(face.key.begin(), face.key.end());
        faces.push_back(face);
      }
    }
  }
  return faces;
}

// Largest number of comparisons per pair, of nodes and faces, and of nodes and boundary triangles:
// some hundredths of a second, and a tenth.
constexpr double most_comparisons = 5e6, most_angles = 1e6;
// Times the face size: smaller depths are round-off.
constexpr double least_depth = 1e-6;

struct Found {
  double depth = 0, size = 0;  // of the face
  Index slot = -1;             // contact node of the slave's body
};

// Depth of x straight behind the nearest face of the master; 0 if it is not behind. near: a face
// that is likely near x, or -1; in the end the nearest one.
Found depth_of(const Vector3& x, const NearFaces& faces, const Vector& sizes, Index& near) {
  constexpr double round_off = 1e-9;
  Found found;
  double nearest = HUGE_VAL, reach = HUGE_VAL;
  if (near >= 0)
    faces.triangles(near, [&](const Triangle& t) {
      reach = std::min(reach, (1 + round_off) * (x - nearest_point(t, x)).norm());
    });
  for (Index f = 0; f < faces.size(); ++f) {
    if (!faces.may_be_nearer(f, x, std::min(nearest, reach))) continue;
    faces.triangles(f, [&](const Triangle& t) {
      const Vector3 away = x - nearest_point(t, x);
      const double distance = away.norm();
      if (distance >= nearest) return;
      nearest = distance;
      near = f;
      const Vector3 normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
      const bool straight_behind = away.dot(normal) <= -(1 - 1e-6) * distance;
      found.depth = straight_behind ? distance : 0;
      found.size = sizes[f];
    });
  }
  return found;
}

bool is_within(const Box& box, const Vector3& x) {
  const Vector3 margin = 1e-9 * (box.upper - box.lower);
  return ((x - box.lower + margin).array() >= 0).all() &&
         ((box.upper + margin - x).array() >= 0).all();
}

// Volume of the master's body, from its mesh. A point behind faces of a surface may be inside the
// body, or beyond its other side at a notch or thin wall.
class Solids {
 public:
  explicit Solids(const Scene& scene) : scene_(scene) {}

  // Null without a readable mesh.
  const Solid* of(const BuiltScene::OfInstance& instance) {
    auto [at, is_new] = solids_.try_emplace(instance.component);
    if (!is_new) return at->second ? &*at->second : nullptr;
    if (!scene_.components.at(instance.component).has_mesh) return nullptr;
    try {
      at->second.emplace(instance.mesh ? *instance.mesh
                                       : read_mesh(scene_.components.at(instance.component).mesh));
    } catch (const InputError&) {
    }
    return at->second ? &*at->second : nullptr;
  }

 private:
  const Scene& scene_;
  std::map<std::string, std::optional<Solid>> solids_;
};

// Nodes of one surface of a pair, and faces of the other.
struct NodesAndFaces {
  const ContactSurface &slave, &master;
};

// A point of the slave just inside its node, off any common boundary.
Vector3 beneath(const ContactSurface& slave, const Points& points, const Vector3& centre,
                Index slot) {
  const auto at =
      std::lower_bound(slave.nodes.begin(), slave.nodes.end(), slot) - slave.nodes.begin();
  const Vector3 x = points.row(slot), outward = slave.area_vectors.row(at).transpose();
  return x + 1e-3 * (centre - x) - 1e-3 * slave.size * outward.normalized();
}

// Nodes of the pair straight behind a face of the master, deepest first. Large surfaces: every k-th
// node.
std::vector<Found> behind_faces(const NodesAndFaces& of, const Simulation& sim,
                                const std::vector<Box>& boxes) {
  const ContactNodes &slave = sim.contact_nodes[of.slave.body],
                     &master = sim.contact_nodes[of.master.body];
  const Points& x = sim.bodies[slave.body]->reference_positions();
  std::vector<Index> inside;
  for (const Index slot : of.slave.nodes)
    if (is_within(boxes[master.body], x.row(slave.nodes[slot]).transpose())) inside.push_back(slot);
  std::vector<Found> list;
  if (inside.empty()) return list;
  const Points points = sim.bodies[master.body]->reference_positions()(master.nodes, Eigen::all);
  const double all =
      static_cast<double>(inside.size()) * static_cast<double>(of.master.faces.rows());
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::ceil(all / most_comparisons)));
  const NearFaces faces(of.master, points);
  Index near = -1;
  for (std::size_t i = 0; i < inside.size(); i += stride) {
    Found found = depth_of(x.row(slave.nodes[inside[i]]).transpose(), faces, of.master.sizes, near);
    found.slot = inside[i];
    if (found.depth > 0) list.push_back(found);
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Found& a, const Found& b) { return a.depth > b.depth; });
  return list;
}

// The deepest of the list inside the master's body. Long lists: every k-th.
const Found* deepest_inside(const std::vector<Found>& list, const NodesAndFaces& of,
                            const BuiltScene& built, Solids& solids) {
  if (list.empty()) return nullptr;
  const Simulation& sim = built.simulation;
  const ContactNodes& slave = sim.contact_nodes[of.slave.body];
  const BuiltScene::OfInstance& master = built.instances[sim.contact_nodes[of.master.body].body];
  const Solid* solid = solids.of(master);
  const Points x = sim.bodies[slave.body]->reference_positions()(slave.nodes, Eigen::all);
  if (solid == nullptr) {  // only its nodes bound it
    const Points& nodes = sim.bodies[sim.contact_nodes[of.master.body].body]->reference_positions();
    const Box box{nodes.colwise().minCoeff().transpose(), nodes.colwise().maxCoeff().transpose()};
    const auto found = std::find_if(list.begin(), list.end(), [&](const Found& node) {
      return is_within(box, x.row(node.slot).transpose());
    });
    return found == list.end() ? nullptr : &*found;
  }
  const Vector3 centre = x(of.slave.nodes, Eigen::all).colwise().mean().transpose();
  const double all = static_cast<double>(list.size()) * static_cast<double>(solid->n_triangles());
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::ceil(all / most_angles)));
  for (std::size_t i = 0; i < list.size(); i += stride) {
    const Vector3 point = beneath(of.slave, x, centre, list[i].slot) - master.placement.position;
    if (solid->holds(master.placement.T.transpose() * point)) return &list[i];
  }
  return nullptr;
}

void warn(const ContactPair& pair, const NodesAndFaces& of, const Found& found,
          const BuiltScene& built, Report& report) {
  const ContactNodes& slave = built.simulation.contact_nodes[of.slave.body];
  const Geometry& geometry = *built.instances[slave.body].geometry;
  const Index id = geometry.node_ids[slave.nodes[found.slot]];
  report.warning(
      pair.source->text() + ": contact " + pair.name + ": node id " + std::to_string(id) + " of " +
      of.slave.name + format_text(" starts %.3g behind the faces of ", found.depth) +
      of.master.name +
      format_text(", more than a face (%.3g): contact takes it for one on the other side and will "
                  "not push it out; look at the positions of the instances",
                  found.size));
}

}  // namespace

Solid::Solid(const Mesh& mesh) {
  std::vector<Face> faces = faces_of(mesh);
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.key < b.key; });
  const auto is_inner = [&](std::size_t f) {
    return (f > 0 && faces[f - 1].key == faces[f].key) ||
           (f + 1 < faces.size() && faces[f + 1].key == faces[f].key);
  };
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (is_inner(f)) continue;
    const auto corner = [&](std::size_t i) {
      return Vector3(mesh.coordinates.row(faces[f].corners[i]));
    };
    triangles_.push_back({corner(0), corner(1), corner(2)});
    if (faces[f].corners[2] != faces[f].corners[3])
      triangles_.push_back({corner(0), corner(2), corner(3)});
  }
}

bool Solid::holds(const Vector3& x) const {
  double half_angles = 0;
  for (const auto& triangle : triangles_) {
    const Vector3 a = triangle[0] - x, b = triangle[1] - x, c = triangle[2] - x;
    const double A = a.norm(), B = b.norm(), C = c.norm();
    half_angles +=
        std::atan2(a.dot(b.cross(c)), A * B * C + a.dot(b) * C + b.dot(c) * A + c.dot(a) * B);
  }
  return std::abs(half_angles) > std::numbers::pi;
}

void look_for_overlaps(const Scene& scene, BuiltScene& built, Report& report) {
  Simulation& sim = built.simulation;
  Solids solids(scene);
  // Joints, after the instances, do not touch
  std::vector<Box> boxes(sim.bodies.size(), {Vector3::Zero(), Vector3::Zero()});
  for (std::size_t b = 0; b < built.instances.size(); ++b)
    boxes[b] = extents(*sim.bodies[b], built.instances[b]);
  for (ContactPair& pair : sim.pairs) {
    if (pair.wall || pair.law.law == ContactLaw::tied) continue;
    const Index a = sim.contact_nodes[pair.slave->body].body,
                b = sim.contact_nodes[pair.master->body].body;
    if (a == b || !boxes[a].meets(boxes[b])) continue;
    const auto look = [&](const NodesAndFaces& of) {
      std::vector<Found> deep = behind_faces(of, sim, boxes);
      const auto rest = std::stable_partition(
          deep.begin(), deep.end(), [](const Found& found) { return found.depth > found.size; });
      const Found shallow = rest != deep.end() ? *rest : Found();
      deep.erase(rest, deep.end());
      if (const Found* found = deepest_inside(deep, of, built, solids)) {
        warn(pair, of, *found, built, report);
        return true;
      }
      if (shallow.depth > least_depth * shallow.size && sim.bodies[a]->at_rest() &&
          sim.bodies[b]->at_rest())
        pair.state().memory.initial_overlap =
            std::max(pair.seen().memory.initial_overlap, shallow.depth);
      return false;
    };
    if (!look({*pair.slave, *pair.master})) look({*pair.master, *pair.slave});
  }
}

}  // namespace cbr
