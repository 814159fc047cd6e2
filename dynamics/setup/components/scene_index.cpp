// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/scene_index.hpp"

#include <set>

#include "common/base/error.hpp"

namespace cbr {
namespace {

using Dampings = std::map<std::string, MaterialDamping>;  // by material

// *DAMPING of the materials that the component's mesh file assigns. Most decks have none, and are
// not parsed again.
Dampings dampings_of_file(const Component& component) {
  Dampings dampings;
  if (!component.has_mesh || !component.material.empty() || !may_hold_materials(component.mesh) ||
      !deck_holds(component.mesh, {"*DAMPING"}))
    return dampings;
  const Mesh mesh = read_mesh(component);
  for (const Block& block : mesh.blocks) {
    const auto given = component.blocks.find(block.name);
    if (!block.material || !is_structure(block) ||
        (given != component.blocks.end() && !given->second.material.empty()))
      continue;
    const FileMaterial& material = *block.material;
    dampings[material.name] = {material.alpha, material.beta, material.loss_factor};
  }
  return dampings;
}

// Adds those of the scene.
Dampings all_dampings(const Scene& scene, const Component& component, Dampings dampings) {
  const auto add = [&](const std::string& material) {
    const auto found = scene.damping.find(material);
    if (!material.empty())
      dampings[material] = found == scene.damping.end() ? MaterialDamping() : found->second;
  };
  add(component.material);
  for (const auto& [block, options] : component.blocks) add(options.material);
  return dampings;
}

MaterialDamping the_only(const Dampings& dampings, const Component& component) {
  for (const auto& [other, of_other] : dampings)
    if (of_other != dampings.begin()->second)
      throw InputError(component.source.text() + ": components." + component.name +
                       ": its materials '" + dampings.begin()->first + "' and '" + other +
                       "' are damped differently: give all materials of a component the same "
                       "damping, or none and instances.NAME.damping");
  return dampings.empty() ? MaterialDamping() : dampings.begin()->second;
}

bool move_alike(const BoundaryCondition& a, const BoundaryCondition& b, Index axis) {
  if (!a.moves(axis) && !b.moves(axis)) return true;
  return a.motion == b.motion && a.value[axis] == b.value[axis] && a.history == b.history;
}

bool move_alike(const std::vector<const BoundaryCondition*>& conditions) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const BoundaryCondition* first = nullptr;
    for (const BoundaryCondition* condition : conditions) {
      if (condition->rotates()) return false;
      if (!condition->fix[axis]) continue;
      if (first == nullptr) first = condition;
      if (!move_alike(*first, *condition, static_cast<Index>(axis))) return false;
    }
  }
  return true;
}

Truncation truncation_of(const Scene& scene, const InstancePlan& plan) {
  const TimeOptions& time = *scene.time;
  if (time.is_static || preload_steps(scene) > 0 || time.integrator != Integrator::exact)
    return Truncation::none;
  // The truncated form has residual compliance at contact faces and loaded sets only
  if (!component_of(scene, *plan.instance).points.empty()) return Truncation::none;
  if (!plan.may_touch || !plan.only_impulses) return Truncation::none;
  if (time.cfl.value_or(0) > 1) return plan.moves_alike ? Truncation::asked : Truncation::none;
  const bool is_free = !plan.is_held() && !plan.is_fixed && !plan.has_loads;
  return !time.step && !time.cfl && is_free ? Truncation::automatic : Truncation::none;
}

void add_contact(const ContactOptions& contact, InstancePlan& plan) {
  plan.may_touch = true;
  plan.only_impulses &= !contact.tied && contact.enforcement == Enforcement::impulse;
}

// Features that follow from the plan.
void add_features(InstancePlan& plan) {
  const SourceLine& own = plan.instance->source;
  add_if(!plan.damping.none(), feature::damping, own, plan.features);
  add_if(plan.damping.needs_modes(), feature::modal_damping, own, plan.features);
  add_if(plan.damping.material.alpha > 0, feature::mass_damping, own, plan.features);
  if (!plan.boundary.empty())
    add_if(!plan.moves_alike, feature::unlike_supports, plan.boundary.front()->source,
           plan.features);
}

}  // namespace

SceneIndex::SceneIndex(const Scene& scene) : scene_(scene), plans_(scene.instances.size()) {
  std::vector<Features> features = features_of(scene);
  std::map<std::string, Dampings> of_file;
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Component& component = component_of(scene, instance);
    places_.try_emplace(instance.name, static_cast<Index>(i));
    plans_[i].instance = &instance;
    plans_[i].is_fixed = features[i].contains(feature::fixed);
    plans_[i].features = std::move(features[i]);
    if (instance.as != InstanceKind::rigid && !of_file.contains(component.name))
      of_file[component.name] = dampings_of_file(component);
    for (const auto& [name, point] : component.points)
      plans_[i].only_impulses &= !point.has_mass() && !point.rigid;
  }
  const auto plan = [&](const std::string& name) -> InstancePlan& { return plans_[place(name)]; };
  for (const BoundaryCondition& condition : scene.boundary)
    plan(condition.instance).boundary.push_back(&condition);
  for (const Load& load : scene.loads)
    if (load.kind != Load::Kind::gravity) plan(load.instance).has_loads = true;
  for (const ContactOptions& contact : scene.contact) {
    for (InstancePlan& any : plans_)
      if (contact.all) add_contact(contact, any);
    for (const SurfaceName* side : {&contact.first, &contact.second})
      if (!contact.all && !side->is_wall()) add_contact(contact, plan(side->instance));
  }
  for (const LinkOptions& link : scene.links)
    for (const SurfaceName* end : {&link.first, &link.second})
      if (!end->is_wall()) plan(end->instance).only_impulses = false;
  for (const SurfaceName& set : scene.output.reactions) plan(set.instance).moves_alike = false;
  for (InstancePlan& of : plans_) {
    const Component& component = component_of(scene, *of.instance);
    of.moves_alike &= move_alike(of.boundary);
    of.damping = {the_only(all_dampings(scene, component, of_file[component.name]), component),
                  of.instance->damping};
    of.truncation = truncation_of(scene, of);
    add_features(of);
  }
}

std::vector<InstancePlan*> SceneIndex::plans(const Component& component, InstanceKind as) {
  std::vector<InstancePlan*> list;
  for (InstancePlan& plan : plans_)
    if (plan.instance->component == component.name && plan.instance->as == as)
      list.push_back(&plan);
  return list;
}

}  // namespace cbr
