// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/turning.hpp"

#include <algorithm>

#include "common/base/error.hpp"
#include "dynamics/setup/skin_shells.hpp"

namespace cbr {
namespace {

constexpr const char* cure = "; take rotations: small, or leave it out";

[[noreturn]] void refuse(const SourceLine& source, const std::string& what) {
  throw InputError(source.text() + ": " + what + cure);
}

[[noreturn]] void refuse(const Instance& instance, const std::string& what) {
  refuse(instance.source, "instance '" + instance.name + "': " + what);
}

void refuse_spin_of_small(const Scene& scene) {
  for (const Instance& instance : scene.instances)
    if (!instance.angular_velocity.isZero(0))
      throw InputError(instance.source.text() + ": instance '" + instance.name +
                       "': angular_velocity needs time: {rotations: large}");
}

}  // namespace

void refuse_what_does_not_turn(const Scene& scene) {
  const TimeOptions& time = *scene.time;
  if (time.rotations == Rotations::small) return refuse_spin_of_small(scene);
  if (time.integrator != Integrator::exact) refuse(time.source, "time.rotations: large goes with integrator: exact only");
  if (time.mass_scaling) refuse(time.source, "time.rotations: large does not go with mass_scaling: true");
  if (!scene.contact.empty())
    refuse(scene.contact.front().source, "contact does not go with time.rotations: large: leave one of the two out");
  if (!scene.boundary.empty()) refuse(scene.boundary.front().source, "time.rotations: large turns free bodies only, not held ones");
  for (const Load& load : scene.loads)
    if (load.kind != Load::Kind::gravity)
      refuse(load.source, "time.rotations: large takes no load but gravity, found a traction or a force");
  if (skin_acts(scene)) refuse(scene.skin->source, "time.rotations: large does not go with shells that act (skin)");
  const auto& fields = scene.output.fields;
  const auto is_stress = [](const std::string& field) { return field == "stress" || field == "nodal_stress"; };
  if (std::any_of(fields.begin(), fields.end(), is_stress))
    refuse(scene.output.source, "output.fields does not go with time.rotations: large: leave one of the two out");
  for (const Instance& instance : scene.instances)
    if (instance.as == InstanceKind::mesh) refuse(instance, "time.rotations: large turns superelements only, found as: mesh");
}

void require_turning(const SceneIndex& index, const Instance& instance, const ReducedComponent& component) {
  if (component.parts.size() != 1) refuse(instance, "time.rotations: large does not turn superelements of several domains");
  if (component.statics)
    refuse(instance, "time.rotations: large does not turn superelements of basis massless, or of few shapes with statics");
  if (coordinates_of_reduced(index, instance, component, component.form != nullptr) != Coordinates::modal)
    refuse(instance, "time.rotations: large needs a superelement with its diagonal form");
  if (component.form->n_rigid != 6)
    refuse(instance, "time.rotations: large turns free bodies of one part only, found " + std::to_string(component.form->n_rigid) +
                         " rigid motions where 6 are allowed");
}

}  // namespace cbr
