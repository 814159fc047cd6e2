// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/points.hpp"

#include "common/mesh/face_weights.hpp"
#include "common/scene/scene_uses.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {
namespace {

// Fractions of the faces' area, or equal weights for a nodeset.
Vector weights_of(const Geometry& geometry, const std::string& instance,
                  const Component::Point& point, const std::vector<Index>& nodes) {
  if (geometry.surfaces.count(point.nodes) == 0)
    return Vector::Ones(static_cast<Index>(nodes.size()));
  const Vector all = face_weights(find_surface(geometry, instance, point.nodes, point.source),
                                  geometry.coordinates);
  return all(nodes);
}

AveragePoint average_point(const Scene& scene, const Instance& instance, const Geometry& geometry,
                           const std::string& name, const Component::Point& point) {
  AveragePoint average;
  average.where = point.source.text() + ": point '" + instance.name + "." + name + "'";
  const std::string set =
      geometry.reduced ? moved_set(component_of(scene, instance), point.nodes) : point.nodes;
  if (const Index node = node_of_point(geometry, name, set); node >= 0) {
    average.nodes = {node, geometry.rotations.at(node)};
    average.is_of_interface = true;
    average.hand = instance.mirror.empty() ? 1 : -1;
    const Vector3 at = point.at.value_or(geometry.coordinates.row(node).transpose());
    average.at = instance.transformation() * at + instance.position;
    return average;
  }
  average.nodes = find_nodes(geometry, instance.name, point.nodes, point.source);
  average.weights = weights_of(geometry, instance.name, point, average.nodes);
  Vector3 at = Vector3::Zero();
  for (std::size_t i = 0; i < average.nodes.size(); ++i)
    at += average.weights[static_cast<Index>(i)] *
          geometry.coordinates.row(average.nodes[i]).transpose();
  at = point.at.value_or(at / average.weights.sum());
  average.at = instance.transformation() * at + instance.position;
  if (instance.as != InstanceKind::rigid)
    add_rotations(geometry, instance, geometry.coordinates, average);
  // Nodes of a rigid body need no coupling
  average.rigid = point.rigid && instance.as != InstanceKind::rigid;
  return average;
}

const Instance& instance_named(const SceneIndex& index, const std::string& name) {
  return index.scene().instances[index.place(name)];
}

const Component::Point& named_point(const SceneIndex& index, const SurfaceName& name) {
  return *point_of(index.scene(), name.instance, name.surface);
}

bool turns_at(const SceneIndex& index, const SurfaceName& end) {
  return !end.is_wall() && index.plan(instance_named(index, end.instance)).turns;
}

}  // namespace

void add_rotations(const Geometry& geometry, const Instance& instance, const Points& positions,
                   AveragePoint& point) {
  if (geometry.rotations.empty() || !lie_on_a_line(point, positions)) return;
  std::map<Index, double> rotations;
  for (std::size_t i = 0; i < point.nodes.size(); ++i)
    if (const auto found = geometry.rotations.find(point.nodes[i]);
        found != geometry.rotations.end())
      rotations[found->second] = point.weights[static_cast<Index>(i)];
  const Index n = point.weights.size();
  point.n_rotations = static_cast<Index>(rotations.size());
  point.hand = instance.mirror.empty() ? 1 : -1;
  point.weights.conservativeResize(n + point.n_rotations);
  Index place = n;
  for (const auto& [node, weight] : rotations) {
    point.nodes.push_back(node);
    point.weights[place++] = weight;
  }
}

Index second_place(const SceneIndex& index, const LinkOptions& link) {
  Index place = static_cast<Index>(
      component_of(index.scene(), instance_named(index, link.second.instance)).points.size());
  for (const LinkOptions& other : index.scene().links) {
    if (&other == &link) break;
    place += other.second.instance == link.second.instance;
  }
  return place;
}

bool turns(const SceneIndex& index, const LinkOptions& link) {
  return turns_at(index, link.first) || turns_at(index, link.second);
}

bool slides(const SceneIndex& index, const LinkOptions& link) {
  if (link.follows_line || link.second.is_wall() || !turns(index, link)) return false;
  bool any = false, all = true;
  for (std::size_t m = 0; m < 3; ++m) {
    any |= link.fix[m] || link.is_sprung(m);
    all &= link.fix[m] && link.value[static_cast<Index>(m)] == 0;
  }
  return any && !all;
}

Index sliding_place(const SceneIndex& index, const LinkOptions& link) {
  const std::string& instance = link.first.instance;
  Index place = static_cast<Index>(
      component_of(index.scene(), instance_named(index, instance)).points.size());
  bool before = true;
  for (const LinkOptions& other : index.scene().links) {
    before &= &other != &link;
    place += other.second.instance == instance;
    place += before && other.first.instance == instance && slides(index, other);
  }
  return place;
}

std::vector<AveragePoint> points_of(const SceneIndex& index, const BuiltScene& built, Index i) {
  const Scene& scene = index.scene();
  const Instance& instance = scene.instances[i];
  const auto average = [&](Index of, const std::string& name, const Component::Point& point) {
    return average_point(scene, scene.instances[of], *built.instances[of].geometry, name, point);
  };
  std::vector<AveragePoint> points;
  for (const auto& [name, point] : component_of(scene, instance).points)
    points.push_back(average(i, name, point));
  for (const LinkOptions& link : scene.links) {
    if (link.second.instance != instance.name) continue;
    AveragePoint second = average(i, link.second.surface, named_point(index, link.second));
    second.rigid = false;  // the named point couples the nodes
    if (!link.follows_line)
      second.at = average(index.place(link.first.instance), link.first.surface,
                          named_point(index, link.first))
                      .at;
    points.push_back(std::move(second));
  }
  for (const LinkOptions& link : scene.links) {
    if (link.first.instance != instance.name || !slides(index, link)) continue;
    AveragePoint sliding = average(i, link.first.surface, named_point(index, link.first));
    sliding.rigid = false;
    sliding.slides = true;
    points.push_back(std::move(sliding));
  }
  return points;
}

Index point_place(const SceneIndex& index, const std::string& instance, const std::string& point) {
  const auto& points = component_of(index.scene(), instance_named(index, instance)).points;
  return std::distance(points.begin(), points.find(point));
}

std::map<Index, std::set<Index>> linked_nodes(const SceneIndex& index, const BuiltScene& built) {
  std::map<Index, std::set<Index>> nodes;
  const auto add = [&](Index instance, Index place) {
    const BodyPoints& points = *built.simulation.bodies[instance]->points();
    nodes[instance].insert({points.translation_node(place), points.rotation_node(place)});
  };
  for_each_point(index, [&](Index i, const std::string& name, const Component::Point& point) {
    const Index place = point_place(index, index.scene().instances[i].name, name);
    if (point.has_mass()) add(i, place);
    if (!point.rigid) return;
    const BodyPoints& points = *built.simulation.bodies[i]->points();
    for (const Index node : points.deformation_nodes(place)) nodes[i].insert(node);
  });
  for (const LinkOptions& link : index.scene().links) {
    add(index.place(link.first.instance),
        point_place(index, link.first.instance, link.first.surface));
    if (!link.second.is_wall()) add(index.place(link.second.instance), second_place(index, link));
    if (slides(index, link)) add(index.place(link.first.instance), sliding_place(index, link));
  }
  return nodes;
}

void for_each_point(const SceneIndex& index, const PointVisit& visit) {
  const Scene& scene = index.scene();
  for (Index i = 0; i < static_cast<Index>(scene.instances.size()); ++i)
    for (const auto& [name, point] : component_of(scene, scene.instances[i]).points)
      visit(i, name, point);
}

}  // namespace cbr
