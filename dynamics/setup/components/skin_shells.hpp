// SPDX-License-Identifier: GPL-3.0-or-later
// The scene's active fictitious shells: stiffness and mass on an instance's own nodes.
#pragma once

#include <string>

#include "common/fem/shell_model.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

// Faces of the instance in the skin, as SURFACE or INSTANCE.SURFACE, linear, without repetition: f
// x 4; none if the skin is inactive.
IndexTable skin_faces(const Scene& scene, const std::string& instance, const Geometry& geometry);

// Shells on these faces, at the nodes of `geometry`; component axes. InputError at the skin's line.
ShellModel skin_shells(const Scene& scene, const std::string& instance, const Geometry& geometry);

}  // namespace cbr
