// SPDX-License-Identifier: GPL-3.0-or-later
// Reference points of components, and links between those of instances.
#include <cmath>

#include "common/base/error.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

const std::vector<std::pair<std::string, std::size_t>> motions{{"x", 0}, {"y", 1}, {"z", 2}, {"rx", 3}, {"ry", 4}, {"rz", 5}};

std::array<bool, 6> parse_motions(const SceneNode& node) {
  std::array<bool, 6> fix{};
  for (const auto& item : node.list_or_one()) {
    const auto motion = item.one_of<std::size_t>(motions);
    if (fix[motion]) item.fail("'" + item.text() + "' is listed twice: remove one");
    fix[motion] = true;
  }
  if (fix == std::array<bool, 6>{}) node.fail("is empty, expected some of x, y, z, rx, ry, rz");
  return fix;
}

// [x axis, y axis]: of any length, at right angles.
Matrix3 parse_link_axes(const SceneNode& node) {
  const auto vectors = node.list();
  if (vectors.size() != 2) node.fail("has " + std::to_string(vectors.size()) + " vectors, expected two: [[x, y, z], [x, y, z]]");
  const Vector3 x = vectors[0].vector3(), y = vectors[1].vector3();
  if (!(x.norm() > 0) || !(y.norm() > 0) || std::abs(x.normalized().dot(y.normalized())) > 1e-9)
    node.fail("are not at right angles, or zero");
  const Vector3 a = x.normalized(), b = (y - a.dot(y) * a).normalized();
  Matrix3 axes;
  axes.row(0) = a.transpose();
  axes.row(1) = b.transpose();
  axes.row(2) << a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0];
  return axes;
}

SurfaceName parse_point_name(const SceneNode& node, const Scene& scene, const SceneNames& names) {
  const SurfaceName name = parse_surface_name(node, scene, names);
  if (point_of(scene, name.instance, name.surface) != nullptr) return name;
  node.fail("found '" + name.text() + "', which is no point: give it under components.NAME.points");
}

}  // namespace

void parse_points(const SceneNode& node, Component& component) {
  const SceneMap map = node.map_of_any();
  for (const auto& [name, value] : map.entries()) {
    require_plain_name(value, "a point", name);
    const SceneMap of = value.map({"surface", "at", "coupling"});
    Component::Point point;
    point.source = value.source();
    point.nodes = of.at("surface").text();
    if (const auto* at = of.find("at")) point.at = at->vector3();
    if (const auto* coupling = of.find("coupling"); coupling != nullptr && coupling->text() != "average")
      coupling->fail("found '" + coupling->text() + "', only 'average' is known: a rigid coupling is still to come");
    component.points.emplace(name, point);
  }
}

void parse_links(const SceneNode& node, const SceneNames& names, Scene& scene) {
  node.for_each_item([&](const SceneNode& item) {
    const SceneMap map = item.map({"between", "fix", "axes"});
    LinkOptions link;
    link.source = item.source();
    const auto ends = map.at("between").list();
    if (ends.size() != 2) map.at("between").fail("has " + std::to_string(ends.size()) + " ends, expected two: [a.POINT, b.POINT], or ground");
    link.first = parse_point_name(ends[0], scene, names);
    if (ends[1].text() == "ground") {
      link.second = {"", "ground", ends[1].source()};
    } else {
      link.second = parse_point_name(ends[1], scene, names);
    }
    if (link.first.text() == link.second.text()) map.at("between").fail("'" + link.first.text() + "' cannot be linked to itself");
    if (const auto* fix = map.find("fix")) link.fix = parse_motions(*fix);
    if (const auto* axes = map.find("axes")) link.axes = parse_link_axes(*axes);
    scene.links.push_back(link);
  });
}

}  // namespace cbr
