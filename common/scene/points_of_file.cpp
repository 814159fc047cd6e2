// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/points_of_file.hpp"

#include <algorithm>
#include <set>

#include "common/base/error.hpp"
#include "common/superelement/superelement_group.hpp"

namespace cbr {
namespace {

Superelement sets_in(const std::filesystem::path& file) try {
  if (!std::filesystem::exists(file) || is_superelement_group(file)) return {};
  return read_superelement(file, {false, false, false});
} catch (const InputError&) {
  return {};
}

}  // namespace

void add_points_of_file(Component& component) {
  const Superelement s = sets_in(component.reduction->superelement);
  std::vector<char> turns(s.node_ids.size(), 0);
  for (std::size_t i = 0; i < s.dof_node.size(); ++i)
    if (s.dof_component[i] > 2) turns[s.dof_node[i]] = 1;
  for (const auto& [name, nodes] : s.nodesets) {
    if (nodes.size() != 1 || turns[nodes.front()] == 0) continue;
    Component::Point& point = component.points[name];
    point.nodes = name;
    point.rigid = true;
    point.source = component.source;
    component.reduction->interface_points.push_back(name);
  }
}

void add_points_of_deck(Component& component) {
  std::error_code error;
  if (!may_hold_materials(component.mesh) ||
      !std::filesystem::is_regular_file(component.mesh, error) ||
      !deck_holds(component.mesh, {"RBE2", "RBE3", "CONM2", "*COUPLING", "*RIGIDBODY", "*MASS",
                                   "*ROTARYINERTIA", "*DISTRIBUTINGCOUPLING"}))
    return;
  for (const auto& [name, point] : read_mesh(component.mesh).points)
    component.points[name] = {point, {point.file, static_cast<int>(point.line)}};
}

void drop_idle_points(Scene& scene) {
  std::set<std::pair<std::string, std::string>> named;  // component, point
  const auto add = [&](const std::string& instance, const std::string& point) {
    for (const Instance& of : scene.instances)
      if (of.name == instance) named.emplace(of.component, point);
  };
  for (const LinkOptions& link : scene.links) {
    add(link.first.instance, link.first.surface);
    add(link.second.instance, link.second.surface);
  }
  for (const SurfaceName& of : scene.output.history) add(of.instance, of.surface);
  for (const Load& load : scene.loads) add(load.instance, load.surface);
  for (auto& item : scene.components)
    std::erase_if(item.second.points, [&](const auto& point) {
      const Component::Point& of = point.second;
      return !of.file.empty() && !of.rigid && !of.has_mass() &&
             !named.contains({item.first, point.first});
    });
}

}  // namespace cbr
