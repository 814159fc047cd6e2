// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/static_forces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

namespace cbr {
namespace {

constexpr double same_direction = 0.9998;  // cosine, 1 degree
// length of an area vector over the area: below, a node has no normal
constexpr double flat_enough = 0.1;

// A nodeset of the interface, or a set by its number, has no faces of its own: then all that is
// kept may touch.
bool all_may_touch(const InterfaceNeeds& needs, const Superelement& s) {
  if (needs.all_touch) return true;
  const auto is_surface = [&](const std::string& name) {
    return std::any_of(s.surfaces.begin(), s.surfaces.end(),
                       [&](const Surface& surface) { return surface.name == name; });
  };
  return std::any_of(needs.touching.begin(), needs.touching.end(),
                     [&](const auto& set) { return !is_surface(set.first); });
}

struct NodeForces {
  bool all_directions = false;
  std::vector<Vector3> normals;
};

void add_normal(const Vector3& area_vector, double area, NodeForces& forces) {
  const double length = area_vector.norm();
  if (!(length > flat_enough * area)) {
    forces.all_directions = true;
    return;
  }
  const Vector3 n = area_vector / length;
  for (const Vector3& other : forces.normals)
    if (other.dot(n) > same_direction) return;
  forces.normals.push_back(n);
  if (forces.normals.size() > 2) forces.all_directions = true;
}

// Area vectors of a surface's nodes, outward: of each the shares of its faces' area vectors, by
// their corners.
struct NodeAreas {
  std::vector<Index> node;  // m, of the superelement
  Points vector;            // m x 3
  Vector area;              // m, the sum of the shares' lengths
};

NodeAreas node_areas(const Superelement& s, const Surface& surface) {
  NodeAreas areas;
  areas.node = surface_nodes(surface);
  std::vector<Index> place(s.node_ids.size(), -1);
  for (std::size_t i = 0; i < areas.node.size(); ++i) place[areas.node[i]] = static_cast<Index>(i);
  areas.vector = Points::Zero(static_cast<Index>(areas.node.size()), 3);
  areas.area = Vector::Zero(areas.vector.rows());
  const IndexTable faces = linear_faces(surface).faces;
  for (Index f = 0; f < faces.rows(); ++f) {
    const Index corners = faces(f, 3) == faces(f, 2) ? 3 : 4;
    const auto x = [&](Index i) { return Vector3(s.coordinates.row(faces(f, i))); };
    const Vector3 a = 0.5 * (x(2) - x(0)).cross(x(3) - x(1));  // of a triangle, x3 = x2, too
    for (Index i = 0; i < corners; ++i) {
      const Index node = place[faces(f, i)];
      areas.vector.row(node) += a.transpose() / static_cast<double>(corners);
      areas.area(node) += a.norm() / static_cast<double>(corners);
    }
  }
  return areas;
}

}  // namespace

std::vector<TouchingSurface> touching_surfaces(const InterfaceNeeds& needs, const Superelement& s,
                                               bool everywhere) {
  std::vector<TouchingSurface> touching;
  const bool all = all_may_touch(needs, s);
  for (const Surface& surface : s.surfaces) {
    const auto found = needs.touching.find(surface.name);
    const bool slides =
        needs.all_touch.value_or(false) || (found != needs.touching.end() && found->second);
    if (all || found != needs.touching.end()) touching.push_back({&surface, everywhere || slides});
  }
  return touching;
}

std::map<std::string, LoadKinds> loads_beside_statics(const CharacteristicOptions& options,
                                                      const InterfaceNeeds& needs) {
  const auto has = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  std::map<std::string, LoadKinds> loads;
  for (const auto& [name, kinds] : needs.loaded) {
    if (has(options.keep, name) || has(needs.held, name)) continue;
    const auto found = needs.touching.find(name);
    const bool is_named = found != needs.touching.end() || needs.all_touch,
               touches = (options.statics.empty() ? is_named : has(options.statics, name)),
               slides = options.shear || needs.all_touch.value_or(false) ||
                        (found != needs.touching.end() && found->second);
    if (touches && slides) continue;
    const LoadKinds left = {kinds.forces, kinds.pressure && !touches, kinds.moments,
                            kinds.means && !touches};
    if (left.acts() || left.means) loads[name] = left;
  }
  return loads;
}

std::vector<Index> loaded_nodes(const InterfaceNeeds& needs, const Superelement& s) {
  std::vector<Index> nodes;
  const auto add = [&](const std::string& name, const std::vector<Index>& its) {
    const auto of = needs.loaded.find(name);
    if (of != needs.loaded.end() && of->second.acts())
      nodes.insert(nodes.end(), its.begin(), its.end());
  };
  for (const Surface& surface : s.surfaces) add(surface.name, surface_nodes(surface));
  for (const auto& [name, its] : s.nodesets) add(name, its);
  return nodes;
}

StaticShare static_forces(const std::vector<TouchingSurface>& touching,
                          const std::vector<char>& is_kept, const Superelement& s,
                          const std::vector<Index>& loaded) {
  std::map<Index, NodeForces> of_node;
  for (const Index node : loaded) of_node[node].all_directions = true;
  for (const auto& [surface, all_directions] : touching) {
    const NodeAreas areas = node_areas(s, *surface);
    for (std::size_t i = 0; i < areas.node.size(); ++i) {
      if (!is_kept.empty() && is_kept[areas.node[i]] != 0) continue;
      NodeForces& node = of_node[areas.node[i]];
      const auto row = static_cast<Index>(i);
      node.all_directions |= all_directions;
      if (!node.all_directions) add_normal(areas.vector.row(row), areas.area(row), node);
    }
  }
  StaticShare forces;
  std::vector<Vector3> directions;
  for (const auto& [node, of] : of_node) {
    std::vector<Vector3> its = of.normals;
    if (of.all_directions) its = {Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};
    forces.node.insert(forces.node.end(), its.size(), node);
    directions.insert(directions.end(), its.begin(), its.end());
  }
  forces.direction.resize(forces.size(), 3);
  for (Index i = 0; i < forces.size(); ++i) forces.direction.row(i) = directions[i];
  return forces;
}

}  // namespace cbr
