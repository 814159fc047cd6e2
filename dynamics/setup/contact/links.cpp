// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/links.hpp"

#include <algorithm>
#include <utility>

#include "common/base/error.hpp"
#include "common/mesh/face_weights.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {
namespace {

// Shares of the faces' area, or one for each node of a nodeset.
Vector weights_of(const Geometry& geometry, const std::string& instance, const Component::Point& point,
                  const std::vector<Index>& nodes) {
  if (geometry.surfaces.count(point.nodes) == 0) return Vector::Ones(static_cast<Index>(nodes.size()));
  const Vector all = face_weights(find_surface(geometry, instance, point.nodes, point.source), geometry.coordinates);
  return all(nodes);
}

AveragePoint average_point(const Instance& instance, const Geometry& geometry, const Component::Point& point) {
  AveragePoint average;
  average.nodes = find_nodes(geometry, instance.name, point.nodes, point.source);
  average.weights = weights_of(geometry, instance.name, point, average.nodes);
  Vector3 at = Vector3::Zero();
  for (std::size_t i = 0; i < average.nodes.size(); ++i)
    at += average.weights[static_cast<Index>(i)] * geometry.coordinates.row(average.nodes[i]).transpose();
  at = point.at.value_or(at / average.weights.sum());
  average.at = instance.transformation() * at + instance.position;
  return average;
}

const Instance& instance_named(const SceneIndex& index, const std::string& name) { return index.scene().instances[index.place(name)]; }

const Component::Point& named_point(const SceneIndex& index, const SurfaceName& name) {
  return *point_of(index.scene(), name.instance, name.surface);
}

// The place of the link among those whose second end is this instance, behind the instance's own points.
Index second_place(const SceneIndex& index, const LinkOptions& link) {
  Index place = static_cast<Index>(component_of(index.scene(), instance_named(index, link.second.instance)).points.size());
  for (const LinkOptions& other : index.scene().links) {
    if (&other == &link) break;
    place += other.second.instance == link.second.instance;
  }
  return place;
}

// What one of the two pairs of a link holds.
void add_pair(const LinkOptions& link, const std::string& what, std::size_t first_motion, Index body_a, Index node_a, Index body_b,
              Index node_b, Simulation& sim) {
  ContactPoint point;
  point.frame = link.axes;
  bool any = false;
  for (std::size_t d = 0; d < 3; ++d) {
    any |= link.fix[first_motion + d];
    // A row of zeros holds nothing
    if (!link.fix[first_motion + d]) point.frame.row(static_cast<Index>(d)).setZero();
  }
  if (!any) return;
  const auto surface = [&](const SurfaceName& name, Index body) {
    auto of = std::make_shared<ContactSurface>();
    of->name = name.text() + what;
    of->body = body;
    of->sizes = Vector::Zero(1);
    return of;
  };
  ContactPair pair;
  pair.source = std::make_shared<const SourceLine>(link.source);
  pair.name = link.first.text() + " - " + link.second.text() + what;
  pair.law = {ContactLaw::tied, 0};
  pair.is_link = true;
  pair.slave = surface(link.first, body_a);
  pair.master = surface(link.second, body_b);
  PairState& state = pair.state();
  state.ties.terms.push_back({body_a, node_a, 1});
  if (node_b >= 0) state.ties.terms.push_back({body_b, node_b, -1});
  point.n_terms = static_cast<Index>(state.ties.terms.size());
  state.ties.points.push_back(point);
  const auto reference = [&](Index contact, Index node) {
    const ContactNodes& nodes = sim.contact_nodes[contact];
    return Vector3(sim.bodies[nodes.body]->reference_positions().row(nodes.nodes[node]).transpose());
  };
  state.tie_offset = reference(body_a, node_a).transpose();
  if (node_b >= 0) state.tie_offset -= reference(body_b, node_b).transpose();
  sim.pairs.push_back(std::move(pair));
}

}  // namespace

std::vector<AveragePoint> points_of(const SceneIndex& index, const BuiltScene& built, Index i) {
  const Scene& scene = index.scene();
  const Instance& instance = scene.instances[i];
  const auto average = [&](Index of, const Component::Point& point) {
    return average_point(scene.instances[of], *built.instances[of].geometry, point);
  };
  std::vector<AveragePoint> points;
  for (const auto& [name, point] : component_of(scene, instance).points) points.push_back(average(i, point));
  for (const LinkOptions& link : scene.links) {
    if (link.second.instance != instance.name) continue;
    AveragePoint second = average(i, named_point(index, link.second));
    second.at = average(index.place(link.first.instance), named_point(index, link.first)).at;
    points.push_back(std::move(second));
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
    const auto& body = static_cast<const PointedBody&>(*built.simulation.bodies[instance]);
    nodes[instance].insert({body.translation_node(place), body.rotation_node(place)});
  };
  for (const LinkOptions& link : index.scene().links) {
    add(index.place(link.first.instance), point_place(index, link.first.instance, link.first.surface));
    if (!link.second.is_wall()) add(index.place(link.second.instance), second_place(index, link));
  }
  return nodes;
}

void add_links(const SceneIndex& index, const std::map<Index, Index>& contact_of_instance, BuiltScene& built) {
  Simulation& sim = built.simulation;
  const auto slot = [&](Index contact, Index node) {
    const auto& nodes = sim.contact_nodes[contact].nodes;
    return static_cast<Index>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
  };
  for (const LinkOptions& link : index.scene().links) {
    const Index a = index.place(link.first.instance), contact_a = contact_of_instance.at(a);
    const auto& body_a = static_cast<const PointedBody&>(*sim.bodies[a]);
    const Index place_a = point_place(index, link.first.instance, link.first.surface);
    Index contact_b = contact_a, translation_b = -1, rotation_b = -1;
    if (!link.second.is_wall()) {
      const Index b = index.place(link.second.instance), place_b = second_place(index, link);
      const auto& body_b = static_cast<const PointedBody&>(*sim.bodies[b]);
      contact_b = contact_of_instance.at(b);
      translation_b = slot(contact_b, body_b.translation_node(place_b));
      rotation_b = slot(contact_b, body_b.rotation_node(place_b));
    } else {
      built.momentum_is_kept = false;
    }
    add_pair(link, "", 0, contact_a, slot(contact_a, body_a.translation_node(place_a)), contact_b, translation_b, sim);
    add_pair(link, ", moment", 3, contact_a, slot(contact_a, body_a.rotation_node(place_a)), contact_b, rotation_b, sim);
  }
}

}  // namespace cbr
