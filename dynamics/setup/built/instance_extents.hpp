// SPDX-License-Identifier: GPL-3.0-or-later
// The box that an instance fills.
#pragma once

#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Of the nodes; a superelement has those of its interface only, and its inertia tells how far it
// reaches beyond them: the edges of a box with its mass and inertia. Scene axes, at the start.
Box extents(const Body& body, const BuiltScene::OfInstance& instance);

}  // namespace cbr
