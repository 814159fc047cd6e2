// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/bodies/turning.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/base/format_text.hpp"

namespace cbr {
namespace {

// Whether the link constrains translations and leaves a rotation free.
bool is_hinge(const LinkOptions& link) {
  bool holds = false, lets_go = false;
  for (std::size_t m = 0; m < 3; ++m) {
    holds |= link.fix[m];
    lets_go |= !link.fix[m + 3] && (!link.is_sprung(m + 3) || link.bends(m + 3));
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

bool allows_large(const Scene& scene) {
  return exceeded_limit(feature::large_rotation, features_of_run(scene)).empty();
}

Rotations resolved(const Scene& scene, bool wants_large) {
  if (scene.time->rotations != Rotations::automatic) return scene.time->rotations;
  const bool spins = std::any_of(scene.instances.begin(), scene.instances.end(),
                                 [](const Instance& i) { return !i.angular_velocity.isZero(0); });
  const bool drives = std::any_of(scene.links.begin(), scene.links.end(), [](const LinkOptions& l) {
    return l.motion != SupportMotion::none && !l.turn.isZero(0);
  });
  const bool may = wants_large || drives || any_hangs(scene);
  return spins || (may && allows_large(scene)) ? Rotations::large : Rotations::small;
}

std::vector<std::string> notes_of_spin(const Instance& instance, const Superelement& superelement,
                                       const ModalBody& body) {
  std::vector<std::string> notes;
  if (!body.frame()->feels_spin()) {
    notes.push_back("component '" + instance.component +
                    "' turns without the forces of its spin on its modes: " +
                    (superelement.has_interface_matrices()
                         ? "its superelement file is older than 1.8 (cbr-reduce --force)"
                         : "basis " + superelement.basis + " does not know them"));
  }
  const ModalForm& form = body.form();
  const double lowest = form.omega.size() > form.n_rigid ? form.omega[form.n_rigid] : HUGE_VAL;
  const double spin = instance.angular_velocity.norm();
  if (spin > 0.1 * lowest)
    notes.push_back(
        "instance '" + instance.name + "' spins at " + number_text(spin) +
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
    if (!index.plan(instance).turns) names += (names.empty() ? "" : ", ") + instance.name;
  return names.empty() ? names
                       : "bodies without supports turn by any angle; linear as ever: " + names;
}

}  // namespace cbr
