// SPDX-License-Identifier: GPL-3.0-or-later
// The points of a superelement that is used as it is.
#pragma once

#include "common/scene/scene.hpp"

namespace cbr {

// Nodes with six dofs become points of the component, under the names of the sets that have them
// alone. None of a file that is not there or is damaged: reading it as a whole gives the error.
// Precondition: the component has no mesh.
void add_points_of_file(Component& component);

}  // namespace cbr
