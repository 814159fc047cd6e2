// SPDX-License-Identifier: GPL-3.0-or-later
// Checks before assembly: materials, nodes and elements that give no usable stiffness and mass.
#pragma once

#include <vector>

#include "common/fem/assembly.hpp"

namespace cbr {

// As assemble() has them. InputError: a material out of range; an inverted, degenerate or repeated
// element, by its id and block; sizes and units whose matrices a double cannot hold.
void check_mesh(const Mesh& mesh, const std::vector<BlockProperties>& properties);

}  // namespace cbr
