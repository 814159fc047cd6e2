// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/scene_uses.hpp"

#include <algorithm>
#include <set>

namespace cbr {

std::vector<SetUse> set_uses(const Scene& scene, const Component& component, InstanceKind as) {
  std::set<std::string> instances;
  for (const Instance& instance : scene.instances)
    if (instance.component == component.name && instance.as == as) instances.insert(instance.name);
  std::vector<SetUse> uses;
  const auto add = [&](const std::string& key, const SurfaceName& name, bool needs_faces,
                       bool may_be_inside = false, bool is_of_stress = false) {
    if (instances.count(name.instance) > 0)
      uses.push_back({key, name.instance, name.surface, name.source, needs_faces, may_be_inside,
                      is_of_stress});
  };
  for (const BoundaryCondition& held : scene.boundary)
    add("boundary", {held.instance, held.nodes, held.source}, false);
  for (const ContactOptions& contact : scene.contact) {
    if (contact.all) continue;
    add("contact", contact.first, true);
    add("contact", contact.second, true);
  }
  for (const SurfaceName& name : scene.output.history)
    if (point_of(scene, name.instance, name.surface) == nullptr)
      add("output.history", name, false, true);
  if (!instances.empty())
    for (const auto& [name, point] : component.points)
      if (as != InstanceKind::superelement || !is_interface_point(component, name))
        uses.push_back(
            {"points", *instances.begin(),
             as == InstanceKind::superelement ? moved_set(component, point.nodes) : point.nodes,
             point.source, false});
  for (const StressOptions& stress : scene.output.stress)
    if (!stress.set.empty())
      add("output.stress", {stress.instance, stress.set, stress.source}, false, true, true);
  return uses;
}

bool is_interface_point(const Component& component, const std::string& name) {
  if (!component.reduction) return false;
  const auto& points = component.reduction->interface_points;
  return std::find(points.begin(), points.end(), name) != points.end();
}

std::string moved_set(const Component& component, const std::string& set) {
  for (const auto& [name, point] : component.points)
    if (point.nodes == set && is_interface_point(component, name)) return name;
  return set;
}

std::string place_of(const SetUse& use) {
  return use.source.text() + ": " + use.key + ": '" + use.instance + "." + use.set + "': ";
}

bool skin_acts(const Scene& scene) {
  return scene.skin && scene.skin->thickness > 0 &&
         (scene.skin->youngs_modulus > 0 || scene.skin->density > 0);
}

}  // namespace cbr
