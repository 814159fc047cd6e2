// SPDX-License-Identifier: GPL-3.0-or-later
// Converts points of a superelement's interface to nodes of three dofs, as bodies need.
#pragma once

#include <map>

#include "common/superelement/superelement.hpp"

namespace cbr {

// Nodes with six dofs keep x, y, z. Their rotations become a node at the same position, after all
// others. Its components stay 3, 4, 5, which identifies rotations in rigid motions. Returns the
// rotation node of each such node.
std::map<Index, Index> separate_rotations(Superelement& s);

}  // namespace cbr
