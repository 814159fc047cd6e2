// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/instance_plan.hpp"

#include "dynamics/setup/components/skin_shells.hpp"

namespace cbr {
namespace {

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
