// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/contact: pairs, ties and links, and their initial state.
//
// Contact pairs of a scene: the slave side, the nodes in contact, and the weights of nodal
// enforcement.
#pragma once

#include <vector>

#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Fills contact_nodes and pairs. The finer surface (smaller mean face) gives the slave nodes; of
// equal ones the first named. Adds links, and joints after the bodies. Returns the kind of contact
// per body. Warns of `nodal` enforcement with its weights.
std::vector<ContactKind> add_contact(const SceneIndex& index, BuiltScene& built, Report& report);

}  // namespace cbr
