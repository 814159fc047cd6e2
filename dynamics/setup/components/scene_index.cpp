// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/scene_index.hpp"

#include <set>

#include "common/base/error.hpp"
#include "dynamics/setup/components/contact_faces.hpp"

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

// Largest number of dofs for which an optional diagonal form is computed. It takes seconds, and
// makes every step faster.
constexpr Index small_enough_to_diagonalise = 1500;

BodyKind body_of_superelement(const TimeOptions& time, const PlannedComponent& of,
                              const InstancePlan& plan) {
  const bool has_shells = plan.n_shell_faces > 0;
  const BodyKind modal = has_shells ? BodyKind::form_with_shells : BodyKind::form;
  if (time.integrator == Integrator::exact || of.has_only_modes) return modal;
  const bool stored = of.has_form && !plan.is_held() && !of.diagonal_limit;
  const bool is_small = of.n_dofs <= of.diagonal_limit.value_or(small_enough_to_diagonalise);
  return !has_shells && (stored || is_small) ? modal : BodyKind::coupled;
}

BodyKind body_of_mesh(const TimeOptions& time, const PlannedComponent& of,
                      const InstancePlan& plan) {
  if (of.as_modes) return BodyKind::mesh_modes;
  const bool is_coupled = time.integrator == Integrator::newmark || time.is_static ||
                          plan.n_shell_faces > 0 || !of.geometry.rotations.empty();
  return is_coupled ? BodyKind::coupled : BodyKind::mesh;
}

// Meshes and dense blocks under `exact` move by central differences.
Scheme scheme_of(const TimeOptions& time, BodyKind body) {
  if (time.integrator == Integrator::newmark) return Scheme::newmark;
  const bool is_modal = body != BodyKind::coupled && body != BodyKind::mesh;
  return time.integrator == Integrator::exact && is_modal ? Scheme::exact
                                                          : Scheme::central_difference;
}

void plan_body(const Scene& scene, const PlannedComponent& of, InstancePlan& plan) {
  const Instance& instance = *plan.instance;
  const TimeOptions& time = *scene.time;
  const bool is_reduced = instance.as == InstanceKind::superelement,
             has_rotations = !of.geometry.rotations.empty();
  plan.n_shell_faces = skin_faces(scene, instance.name, of.geometry).rows();
  if (is_reduced) plan.body = body_of_superelement(time, of, plan);
  if (instance.as == InstanceKind::mesh) plan.body = body_of_mesh(time, of, plan);
  plan.scheme = scheme_of(time, plan.body);
  plan.as_stored = plan.moves_freely_in_form() && of.has_form;
  if (scene.skin)
    add_if(plan.n_shell_faces > 0, feature::skin_of_instance, scene.skin->source, plan.features);
  const bool is_mesh =
      plan.body == BodyKind::mesh || (plan.body == BodyKind::coupled && !is_reduced);
  add_if(has_rotations, feature::rotations, instance.source, plan.features);
  const Component& component = component_of(scene, instance);
  add_if(
      has_rotations && instance.as == InstanceKind::mesh && component.mass == MassKind::consistent,
      feature::mesh_with_shells, component.source, plan.features);
  add_if(is_mesh, feature::mesh, instance.source, plan.features);
  add_if(plan.body == BodyKind::mesh_modes, feature::mesh_modes, instance.source, plan.features);
  add_if(plan.body == BodyKind::coupled && is_reduced, feature::dense, time.source, plan.features);
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

void plan_bodies(const Scene& scene, const std::vector<InstancePlan*>& plans,
                 const PlannedComponent& of) {
  for (InstancePlan* plan : plans) plan_body(scene, of, *plan);
}

void plan_rotation(const Scene& scene, InstancePlan& plan) {
  plan.why_linear = exceeded_limit(feature::large_rotation, plan.features);
  plan.turns = scene.time->rotations == Rotations::large && plan.why_linear.empty();
  // Meshes of shells that stay linear are coupled
  if (plan.turns && plan.body == BodyKind::coupled && plan.instance->as == InstanceKind::mesh)
    plan.body = BodyKind::mesh;
}

}  // namespace cbr
