// SPDX-License-Identifier: GPL-3.0-or-later
// Points of components that files have, not the scene.
#pragma once

#include "common/scene/scene.hpp"

namespace cbr {

// Nodes with six dofs become points of the component, under the names of the sets that have them
// alone. None of a file that is not there or is damaged: reading it as a whole gives the error.
// Precondition: the component has no mesh.
void add_points_of_file(Component& component);

// Those of the component's deck: RBE2, RBE3, *COUPLING, *RIGID BODY, with their masses. None of a
// file that is not there. InputError: the deck is wrong.
void add_points_of_deck(Component& component);
// Leaves out those of decks that neither have a mass, nor are rigid, nor are named by the scene.
void drop_idle_points(Scene& scene);

}  // namespace cbr
