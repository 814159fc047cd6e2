// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/scene_index.hpp"

#include "common/base/text_lines.hpp"

namespace cbr {
namespace {

// Most decks have no damping and are not parsed again.
bool holds_damping(const std::filesystem::path& deck) {
  for (const auto& file : mesh_files(deck)) {
    TextLines lines(file, true);
    while (lines.next()) {
      if (!lines.line().starts_with('*')) continue;
      std::string keyword = lines.line().substr(0, lines.line().find(','));
      std::erase_if(keyword, [](char c) { return c == ' ' || c == '\t'; });
      for (char& c : keyword) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      if (keyword == "*DAMPING") return true;
    }
  }
  return false;
}

}  // namespace

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
  for (const Instance& instance : scene.instances)
    if (instance.as != InstanceKind::rigid) read_damping(component_of(scene, instance));
}

void SceneIndex::read_damping(const Component& component) {
  if (!component.has_mesh || !component.material.empty() || damping_.contains(component.name) ||
      !may_hold_materials(component.mesh))
    return;
  auto& damping = damping_[component.name];
  if (!holds_damping(component.mesh)) return;
  const Mesh mesh = read_mesh(component);
  for (const Block& block : mesh.blocks) {
    const auto given = component.blocks.find(block.name);
    if (!block.material || !is_structure(block) ||
        (given != component.blocks.end() && !given->second.material.empty()))
      continue;
    const FileMaterial& material = *block.material;
    damping[material.name] = {material.alpha, material.beta, material.loss_factor};
  }
}

const std::map<std::string, MaterialDamping>& SceneIndex::damping_of_file(
    const Component& component) const {
  static const std::map<std::string, MaterialDamping> none;
  const auto found = damping_.find(component.name);
  return found == damping_.end() ? none : found->second;
}

}  // namespace cbr
