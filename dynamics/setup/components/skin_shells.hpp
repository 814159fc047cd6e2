// SPDX-License-Identifier: GPL-3.0-or-later
// The scene's fictitious shells, as far as they act: stiffness and mass on an instance's own nodes.
#pragma once

#include <string>
#include <vector>

#include "common/fem/shell_model.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

// Shells without thickness, or with neither modulus nor density, do nothing and cost nothing.
bool skin_acts(const Scene& scene);

// Faces of the instance that the skin names, as SURFACE or INSTANCE.SURFACE, linear, each once: f x
// 4, none when the skin does not act.
IndexTable skin_faces(const Scene& scene, const std::string& instance, const Geometry& geometry);

// The shells on them, on the nodes of `geometry`; component axes. InputError at the skin's line.
ShellModel skin_shells(const Scene& scene, const std::string& instance, const Geometry& geometry);

}  // namespace cbr
