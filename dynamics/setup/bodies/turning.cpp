// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/bodies/turning.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/base/error.hpp"
#include "common/base/number_text.hpp"
#include "common/scene/scene_words.hpp"
#include "dynamics/setup/components/skin_shells.hpp"

namespace cbr {
namespace {

constexpr const char* without =
    "; leave out time.rotations and angular_velocity: it then stays linear";

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

// Rejects settings of the whole run.
void refuse_ways(const Scene& scene) {
  const TimeOptions& time = *scene.time;
  if (time.integrator != Integrator::exact)
    refuse(time.source, "time.rotations: large goes with integrator: exact only",
           "; take integrator: exact, by which meshes move by central differences");
  if (time.is_static || preload_steps(scene) > 0)
    refuse(time.source,
           "time.rotations: large does not go with statics, those before the time 0 included "
           "(preload, pretension, shortening, overlap: resolve)");
  if (skin_acts(scene))
    refuse(scene.skin->source, "time.rotations: large does not go with shells that act (skin)");
}

std::string why_contact_is_linear(const SceneIndex& index, const Instance& instance) {
  if (index.has_only_impulses(instance)) return {};
  for (const ContactOptions& contact : index.scene().contact) {
    // first, as it is cheap: there may be thousands
    if (contact.enforcement == Enforcement::impulse) continue;
    const bool touches = contact.all || contact.first.instance == instance.name ||
                         contact.second.instance == instance.name;
    if (!touches) continue;
    return contact.source.text() + ": contact of instance '" + instance.name +
           "', which turns (time.rotations: large), is enforcement: impulse only, found " +
           word_of(enforcement_words, contact.enforcement) + "; take enforcement: impulse";
  }
  return {};
}

// Nodes of shells have rotations, and moments on them are not supported with large rotation.
bool has_shells(const Component& component) {
  return std::any_of(component.blocks.begin(), component.blocks.end(),
                     [](const auto& block) { return block.second.thickness.has_value(); });
}

std::string why_points_are_linear(const Instance& instance, const Component& component) {
  if (component.points.empty()) return {};
  if (instance.as == InstanceKind::superelement && has_shells(component))
    return "time.rotations: large does not turn points of components with shells";
  const bool is_reduced = instance.as == InstanceKind::superelement && component.reduction;
  if (is_reduced && component.reduction->is_massless())
    return "time.rotations: large does not turn points of basis massless";
  if (is_reduced && !component.reduction->interface_points.empty())
    return "time.rotations: large does not turn points as the interface (reduction.points): name "
           "their sets in reduction.interface";
  for (const auto& [name, point] : component.points)
    if (!point.inertia.isZero(0))
      return "time.rotations: large does not turn a point with inertia ('" + name +
             "'): give it a mass alone, or the inertia to a rigid body that a link welds to it";
  return {};
}

std::string why_loads_are_linear(const Scene& scene, const Instance& instance) {
  if (instance.as != InstanceKind::superelement || !has_shells(component_of(scene, instance)))
    return {};
  for (const Load& load : scene.loads)
    if (load.kind == Load::Kind::moment && !load.on_point && load.instance == instance.name)
      return load.source.text() +
             ": time.rotations: large does not turn moments on components with shells";
  return {};
}

// Whether the link constrains translations and leaves a rotation free.
bool is_hinge(const LinkOptions& link) {
  bool holds = false, lets_go = false;
  for (std::size_t m = 0; m < 3; ++m) {
    holds |= link.fix[m];
    lets_go |= !link.fix[m + 3] && !link.is_sprung(m + 3);
  }
  return holds && lets_go;
}

// Whether a free instance is on a hinge under gravity: its weight has a moment that depends on the
// rotation, which a linear body neglects.
bool any_hangs(const Scene& scene) {
  if (gravity_of(scene) == nullptr) return false;
  std::set<std::string> held;
  for (const BoundaryCondition& condition : scene.boundary) held.insert(condition.instance);
  const auto is_free = [&](const SurfaceName& end) {
    return !end.is_wall() && held.count(end.instance) == 0;
  };
  return std::any_of(scene.links.begin(), scene.links.end(), [&](const LinkOptions& link) {
    return is_hinge(link) && (is_free(link.first) || is_free(link.second));
  });
}

}  // namespace

const Load* gravity_of(const Scene& scene) {
  const auto found = std::find_if(scene.loads.begin(), scene.loads.end(), [](const Load& load) {
    return load.kind == Load::Kind::gravity && !load.value.isZero(0);
  });
  return found == scene.loads.end() ? nullptr : &*found;
}

Rotations resolved(const Scene& scene, bool wants_large) {
  if (scene.time->rotations != Rotations::automatic) return scene.time->rotations;
  const bool spins = std::any_of(scene.instances.begin(), scene.instances.end(),
                                 [](const Instance& i) { return !i.angular_velocity.isZero(0); });
  const bool may = wants_large || any_hangs(scene);
  return spins || (may && what_large_is_refused_for(scene).empty()) ? Rotations::large
                                                                    : Rotations::small;
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
}

std::string what_large_is_refused_for(const Scene& scene) {
  try {
    refuse_ways(scene);
  } catch (const InputError& error) {
    const std::string text = error.what();
    return text.ends_with(without) ? text.substr(0, text.size() - std::string(without).size())
                                   : text;
  }
  return {};
}

std::string why_linear(const SceneIndex& index, const Instance& instance) {
  if (index.is_held(instance))
    return "time.rotations: large turns bodies without supports only: hold it by links to the "
           "ground instead of 'boundary'";
  if (const std::string why = why_contact_is_linear(index, instance); !why.empty()) return why;
  const Scene& scene = index.scene();
  const std::string why = why_points_are_linear(instance, component_of(scene, instance));
  return why.empty() ? why_loads_are_linear(scene, instance) : why;
}

std::string why_linear(const ReducedComponent& component, const Instance& instance) {
  if (component.parts.size() != 1)
    return "time.rotations: large does not turn superelements of several domains: reduce it in one";
  if (component.plans.at(instance.name).has_shells)
    return "time.rotations: large does not go with shells that act (skin)";
  if (!component.form) return "time.rotations: large needs a superelement with its diagonal form";
  const Index n_rigid = component.form->n_rigid;
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

void refuse_to_turn(const Instance& instance, const std::string& why) {
  // the reason contains the line
  if (why.starts_with(instance.source.file + ":")) throw InputError(why);
  refuse(instance, why);
}

std::vector<std::string> notes_of_spin(const Instance& instance, const Superelement& superelement,
                                       const ModalBody& body) {
  std::vector<std::string> notes;
  const std::string name = "instance '" + instance.name + "'";
  if (!body.frame()->feels_spin()) {
    notes.push_back(name + " turns without the forces of its spin on its modes: " +
                    (superelement.has_interface_matrices()
                         ? "its superelement file is older than 1.8 (cbr-reduce --force)"
                         : "basis " + superelement.basis + " does not know them"));
  }
  const ModalForm& form = body.form();
  const double lowest = form.omega.size() > form.n_rigid ? form.omega[form.n_rigid] : HUGE_VAL;
  const double spin = instance.angular_velocity.norm();
  if (spin > 0.1 * lowest)
    notes.push_back(
        name + " spins at " + number_text(spin) +
        " rad/s, more than a tenth of its lowest frequency of " + number_text(lowest) + " rad/s: " +
        (body.frame()->has_coupling() ? "stiffening by the spin is left out"
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
