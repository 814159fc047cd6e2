// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

SceneIndex::SceneIndex(const Scene& scene) : scene_(scene), of_(scene.instances.size()) {
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    places_.try_emplace(scene.instances[i].name, static_cast<Index>(i));
  const auto find = [&](const std::string& name) {
    return &of_[static_cast<std::size_t>(place(name))];
  };
  for (const BoundaryCondition& condition : scene.boundary)
    find(condition.instance)->boundary.push_back(&condition);
  for (const Load& load : scene.loads)
    if (load.kind != Load::Kind::gravity) find(load.instance)->loaded = true;
  for (const ContactOptions& contact : scene.contact) {
    const bool nodal = contact.enforcement == Enforcement::nodal;
    const bool other = contact.tied || contact.enforcement != Enforcement::impulse;
    if (contact.all) {
      all_touch_ = true;
      all_nodal_ |= nodal;
      all_other_ |= other;
    }
    for (const SurfaceName* side : {&contact.first, &contact.second}) {
      if (contact.all || side->is_wall()) continue;
      Of* of = find(side->instance);
      of->touches = true;
      of->nodal |= nodal;
      of->other |= other;
    }
  }
  for (const LinkOptions& link : scene.links)
    for (const SurfaceName* end : {&link.first, &link.second})
      if (!end->is_wall()) find(end->instance)->other = true;
  for (const Instance& instance : scene.instances)
    for (const auto& [name, point] : component_of(scene, instance).points)
      if (point.has_mass() || point.rigid) find(instance.name)->other = true;
}

}  // namespace cbr
