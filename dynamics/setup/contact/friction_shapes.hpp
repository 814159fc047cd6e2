// SPDX-License-Identifier: GPL-3.0-or-later
// Checks residual compliance for friction.
#pragma once

#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Checks faces of basis characteristic in a pair with friction. Warns of a face without residual
// compliance and with fewer interface modes than directions. It slides and sticks in large patches,
// and friction dissipates several times too much (docs/decisions/characteristic.md). InputError:
// residual compliance along the normals only.
void look_for_friction_shapes(const ContactPair& pair, const BuiltScene& built, const Scene& scene,
                              Report& report);

}  // namespace cbr
