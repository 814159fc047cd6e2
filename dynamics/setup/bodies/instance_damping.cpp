// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/bodies/instance_damping.hpp"

#include <map>
#include <string>

#include "common/base/error.hpp"

namespace cbr {
namespace {

MaterialDamping damping_of_material(const Scene& scene, const std::string& material) {
  const auto found = scene.damping.find(material);
  return found == scene.damping.end() ? MaterialDamping() : found->second;
}

// Damping of the component's materials, including those of its mesh file.
std::map<std::string, MaterialDamping> dampings_of(const SceneIndex& index,
                                                   const Component& component) {
  std::map<std::string, MaterialDamping> all = index.damping_of_file(component);
  const auto add = [&](const std::string& material) {
    if (!material.empty()) all[material] = damping_of_material(index.scene(), material);
  };
  add(component.material);
  for (const auto& [block, options] : component.blocks) add(options.material);
  return all;
}

[[noreturn]] void refuse_damping(const Instance& instance, const std::string& what) {
  throw InputError(instance.source.text() + ": instance '" + instance.name + "': " + what);
}

}  // namespace

Damping damping_of(const SceneIndex& index, const Instance& instance) {
  const Component& component = component_of(index.scene(), instance);
  const std::map<std::string, MaterialDamping> dampings = dampings_of(index, component);
  Damping damping;
  damping.modal = instance.damping;
  if (!dampings.empty()) damping.material = dampings.begin()->second;
  for (const auto& [other, of_other] : dampings) {
    if (of_other == damping.material) continue;
    throw InputError(
        component.source.text() + ": components." + component.name + ": its materials '" +
        dampings.begin()->first + "' and '" + other +
        "' are damped differently: give all materials of a component the same damping" +
        (instance.as == InstanceKind::superelement
             ? ", or none and instances." + instance.name + ".damping: {ratio: ...}"
             : ""));
  }
  if (!damping.none() && index.is_nodal(instance))
    throw InputError(instance.source.text() + ": instance '" + instance.name +
                     "': damping cannot be had with contact of enforcement: nodal: use "
                     "enforcement: impulse or penalty");
  return damping;
}

MaterialDamping damping_without_modes(const SceneIndex& index, const Instance& instance) {
  const Damping damping = damping_of(index, instance);
  if (damping.needs_modes())
    refuse_damping(
        instance,
        instance.as == InstanceKind::mesh
            ? "loss_factor and damping of modes cannot be had with as: mesh: give its material "
              "damping: {alpha, beta}, or use as: superelement"
            : "loss_factor and damping of modes need a superelement in its diagonal form: give its "
              "material damping: {alpha, beta}, or use integrator: exact or a larger "
              "--diagonal-limit");
  return damping.material;
}

}  // namespace cbr
