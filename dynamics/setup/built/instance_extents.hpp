// SPDX-License-Identifier: GPL-3.0-or-later
// Bounding box of an instance.
#pragma once

#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Box around its nodes. A superelement has interface nodes only, so that a box with its mass and
// inertia is added. Scene axes, initial position.
Box extents(const Body& body, const BuiltScene::OfInstance& instance);

}  // namespace cbr
