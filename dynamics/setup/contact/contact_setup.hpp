// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/contact: pairs, ties and links; where they start.
//
// Contact pairs of a scene: which side is the slave, which nodes take part, and what a nodal
// enforcement weighs.
#pragma once

#include <vector>

#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Fills contact_nodes and pairs. The finer surface (smaller mean face) gives the slave nodes; of
// equal ones the first named. Adds links, and joints behind the bodies. Returns per body how it is
// in a pair. Warns of `nodal` enforcement with the weights that it uses.
std::vector<ContactKind> add_contact(const SceneIndex& index, BuiltScene& built, Report& report);

}  // namespace cbr
