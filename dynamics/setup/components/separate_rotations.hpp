// SPDX-License-Identifier: GPL-3.0-or-later
// Points of a superelement's interface as nodes of three dofs each, which is what bodies know.
#pragma once

#include <map>

#include "common/superelement/superelement.hpp"

namespace cbr {

// Nodes with six dofs keep x, y, z. Their rotations get a node of their own at the same place,
// behind all others; its components stay 3, 4, 5, by which rigid motions are told. Returns the node
// of the rotations of each such node.
std::map<Index, Index> separate_rotations(Superelement& s);

}  // namespace cbr
