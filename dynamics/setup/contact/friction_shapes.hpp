// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a face can give way to friction.
#pragma once

#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Of a pair with friction, its faces of basis characteristic. Warns of one without statics whose
// nodes have fewer shapes than directions: it slides and sticks in large pieces, and friction takes
// several times what it should (docs/decisions/characteristic.md). InputError: one with statics
// along the normals alone.
void look_for_friction_shapes(const ContactPair& pair, const BuiltScene& built, const Scene& scene,
                              Report& report);

}  // namespace cbr
