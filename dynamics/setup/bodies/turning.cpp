// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/bodies/turning.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/number_text.hpp"
#include "common/scene/scene_words.hpp"
#include "dynamics/setup/components/skin_shells.hpp"

namespace cbr {
namespace {

constexpr const char* without = "; take rotations: small, without angular_velocity";

[[noreturn]] void refuse(const SourceLine& source, const std::string& what,
                         const std::string& cure = without) {
  throw InputError(source.text() + ": " + what + cure);
}

[[noreturn]] void refuse(const Instance& instance, const std::string& what) {
  refuse(instance.source, "instance '" + instance.name + "': " + what);
}

void refuse_spin(const Instance& instance, const std::string& why) {
  if (instance.angular_velocity.isZero(0)) return;
  throw InputError(instance.source.text() + ": instance '" + instance.name +
                   "': angular_velocity needs " + why);
}

// What the whole run does.
void refuse_ways(const Scene& scene) {
  const TimeOptions& time = *scene.time;
  if (time.integrator != Integrator::exact)
    refuse(time.source, "time.rotations: large goes with integrator: exact only",
           "; take integrator: exact, by which meshes move by central differences");
  if (time.mass_scaling)
    refuse(time.source, "time.rotations: large does not go with mass_scaling: true",
           "; take mass_scaling: false");
  if (time.is_static || preload_steps(scene) > 0)
    refuse(time.source,
           "time.rotations: large does not go with statics, those before the time 0 included "
           "(preload, pretension, shortening, overlap: resolve)");
  if (skin_acts(scene))
    refuse(scene.skin->source, "time.rotations: large does not go with shells that act (skin)");
}

void refuse_contact(const SceneIndex& index, const ContactOptions& contact) {
  const Scene& scene = index.scene();
  if (contact.enforcement == Enforcement::impulse) return;
  const auto touches = [&](const Instance& instance) {
    return turns(index, instance) && (contact.all || contact.first.instance == instance.name ||
                                      contact.second.instance == instance.name);
  };
  const auto found = std::find_if(scene.instances.begin(), scene.instances.end(), touches);
  if (found == scene.instances.end()) return;
  refuse(contact.source,
         "contact of instance '" + found->name +
             "', which turns (time.rotations: large), is enforcement: impulse "
             "only, found " +
             word_of(enforcement_words, contact.enforcement),
         "; take enforcement: impulse");
}

// Their nodes' rotations take moments, which loads of bodies that turn do not know.
bool has_shells(const Component& component) {
  return std::any_of(component.blocks.begin(), component.blocks.end(),
                     [](const auto& block) { return block.second.thickness.has_value(); });
}

void refuse_points(const Instance& instance, const Component& component) {
  if (component.points.empty()) return;
  if (instance.as == InstanceKind::superelement && has_shells(component))
    refuse(instance, "time.rotations: large does not turn points of components with shells");
  const bool is_reduced = instance.as == InstanceKind::superelement && component.reduction;
  if (is_reduced && component.reduction->is_massless())
    refuse(instance, "time.rotations: large does not turn points of basis massless");
  if (is_reduced && !component.reduction->interface_points.empty())
    refuse(instance,
           "time.rotations: large does not turn points as the interface (reduction.points): name "
           "their sets in reduction.interface");
  for (const auto& [name, point] : component.points)
    if (!point.inertia.isZero(0))
      refuse(instance, "time.rotations: large does not turn a point with inertia ('" + name +
                           "'): give it a mass alone, or the inertia to a rigid body that a link "
                           "welds to it");
}

void refuse_what_acts(const SceneIndex& index) {
  const Scene& scene = index.scene();
  for (const ContactOptions& contact : scene.contact) refuse_contact(index, contact);
  for (const Instance& instance : scene.instances)
    if (turns(index, instance)) refuse_points(instance, component_of(scene, instance));
  for (const Load& load : scene.loads) {
    if (load.kind != Load::Kind::moment || load.on_point) continue;
    const Instance& instance =
        scene.instances[static_cast<std::size_t>(index.place(load.instance))];
    if (turns(index, instance) && instance.as == InstanceKind::superelement &&
        has_shells(component_of(scene, instance)))
      refuse(load.source, "time.rotations: large does not turn moments on components with shells");
  }
}

}  // namespace

Rotations resolved(const Scene& scene, bool wants_large) {
  if (scene.time->rotations != Rotations::automatic) return scene.time->rotations;
  const bool spins = std::any_of(scene.instances.begin(), scene.instances.end(),
                                 [](const Instance& i) { return !i.angular_velocity.isZero(0); });
  return spins || wants_large ? Rotations::large : Rotations::small;
}

bool turns(const SceneIndex& index, const Instance& instance) {
  return index.scene().time->rotations == Rotations::large && !index.is_held(instance) &&
         !index.stays_linear(instance);
}

void refuse_what_does_not_turn(const SceneIndex& index) {
  const Scene& scene = index.scene();
  if (scene.time->rotations == Rotations::small) {
    for (const Instance& instance : scene.instances)
      refuse_spin(instance, "time.rotations: auto or large, found small");
    return;
  }
  refuse_ways(scene);
  for (const Instance& instance : scene.instances)
    if (!turns(index, instance))
      refuse_spin(instance, "a body without supports: held ones do not turn");
  refuse_what_acts(index);
}

std::string what_large_is_refused_for(const Scene& scene) {
  Scene other = scene;
  other.time->rotations = Rotations::large;
  try {
    refuse_what_does_not_turn(SceneIndex(other));
  } catch (const InputError& error) {
    const std::string text = error.what();
    return text.ends_with(without) ? text.substr(0, text.size() - std::string(without).size())
                                   : text;
  }
  return {};
}

std::string why_linear(const ReducedComponent& component, const Instance& instance) {
  if (component.parts.size() != 1)
    return "time.rotations: large does not turn superelements of several domains: reduce it in one";
  if (component.plans.at(instance.name).has_shells)
    return "time.rotations: large does not go with shells that act (skin)";
  if (!component.statics && !component.form)
    return "time.rotations: large needs a superelement with its diagonal form";
  const Index n_rigid =
      component.statics ? component.statics->modal.n_rigid : component.form->n_rigid;
  if (n_rigid == 6) return {};
  return "time.rotations: large turns free bodies of one part only, found " +
         std::to_string(n_rigid) + " rigid motions where 6 are allowed";
}

std::string why_linear(const MeshedComponent& component, const Instance& instance) {
  if (instance.as == InstanceKind::rigid) return {};
  if (component.plans.at(instance.name).coordinates != Coordinates::nodal)
    return "time.rotations: large does not turn meshes with shells, but superelements of them";
  if (component.n_parts == 1) return {};
  return "time.rotations: large turns bodies of one part only, found " +
         std::to_string(component.n_parts) + " parts in the mesh";
}

std::string why_linear(const Damping& damping) {
  if (damping.material.alpha == 0) return {};
  return "damping alpha, which brakes rigid motions, does not go with time.rotations: large: take "
         "beta, or loss_factor or ratios of modes for a superelement";
}

void refuse_to_turn(const Instance& instance, const std::string& why) { refuse(instance, why); }

std::vector<std::string> notes_of_spin(const Instance& instance, const Superelement& superelement,
                                       const TurningBody& body, const SuperelementBody& modal) {
  std::vector<std::string> notes;
  const std::string name = "instance '" + instance.name + "'";
  if (!body.feels_spin()) {
    notes.push_back(name + " turns without the forces of its spin on its modes: " +
                    (superelement.has_interface_matrices()
                         ? "its superelement file is older than 1.8 (cbr-reduce --force)"
                         : "basis " + superelement.basis + " does not know them"));
  }
  const DiagonalForm& form = modal.form();
  const double lowest = form.omega.size() > form.n_rigid ? form.omega[form.n_rigid] : HUGE_VAL;
  const double spin = instance.angular_velocity.norm();
  if (spin > 0.1 * lowest)
    notes.push_back(name + " spins at " + number_text(spin) +
                    " rad/s, more than a tenth of its lowest frequency of " + number_text(lowest) +
                    " rad/s: " +
                    (body.has_coupling() ? "stiffening by the spin is left out"
                                         : "Coriolis forces and stiffening by the spin are left "
                                           "out"));
  return notes;
}

std::string note_of_what_stays(const SceneIndex& index) {
  const Scene& scene = index.scene();
  std::string names;
  if (scene.time->rotations == Rotations::small) return names;
  for (const Instance& instance : scene.instances)
    if (!turns(index, instance)) names += (names.empty() ? "" : ", ") + instance.name;
  return names.empty() ? names
                       : "bodies without supports turn by any angle; linear as ever: " + names;
}

}  // namespace cbr
