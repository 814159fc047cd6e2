// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/motion_plan.hpp"

#include "dynamics/setup/components/skin_shells.hpp"

namespace cbr {
namespace {

// Largest number of dofs for which an optional diagonal form is computed. It takes seconds, and
// makes every step faster.
constexpr Index small_enough_to_diagonalise = 1500;

Coordinates coordinates_of(const TimeOptions& time, const MotionPlan& plan,
                           const PlannedSuperelement& of) {
  if (time.integrator == Integrator::exact || of.has_only_modes) return Coordinates::modal;
  if (plan.has_shells) return Coordinates::coupled;
  const bool stored = of.has_form && !plan.is_held && !of.diagonal_limit;
  const bool is_small = of.n_dofs <= of.diagonal_limit.value_or(small_enough_to_diagonalise);
  return stored || is_small ? Coordinates::modal : Coordinates::coupled;
}

MotionPlan plan_of(const SceneIndex& index, const Instance& instance,
                   const PlannedSuperelement& of) {
  MotionPlan plan;
  plan.has_shells = has_shells(index.scene(), instance, of.geometry);
  plan.is_held = index.is_held(instance);
  plan.coordinates = coordinates_of(*index.scene().time, plan, of);
  plan.as_stored = plan.is_modal() && of.has_form && !plan.is_held && !plan.has_shells;
  return plan;
}

}  // namespace

bool has_shells(const Scene& scene, const Instance& instance, const Geometry& geometry) {
  return skin_acts(scene) && skin_faces(scene, instance.name, geometry).rows() > 0;
}

MotionPlans plan_superelements(const SceneIndex& index, const std::string& component,
                               const PlannedSuperelement& of) {
  MotionPlans plans;
  for (const Instance& instance : index.scene().instances)
    if (instance.component == component && instance.as == InstanceKind::superelement)
      plans[instance.name] = plan_of(index, instance, of);
  return plans;
}

MotionPlans plan_meshes(const SceneIndex& index, const std::string& component,
                        const Geometry& geometry) {
  const TimeOptions& time = *index.scene().time;
  MotionPlans plans;
  for (const Instance& instance : index.scene().instances) {
    if (instance.component != component || instance.as != InstanceKind::mesh) continue;
    MotionPlan& plan = plans[instance.name];
    plan.has_shells = has_shells(index.scene(), instance, geometry);
    plan.is_held = index.is_held(instance);
    const bool is_coupled = time.integrator == Integrator::newmark || time.is_static ||
                            plan.has_shells || !geometry.rotations.empty();
    plan.coordinates = is_coupled ? Coordinates::coupled : Coordinates::nodal;
  }
  return plans;
}

}  // namespace cbr
