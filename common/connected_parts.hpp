// SPDX-License-Identifier: GPL-3.0-or-later
// Which elements of a mesh hold together.
#pragma once

#include <string>
#include <vector>

#include "common/assembly.hpp"

namespace cbr {

// Per model node the number (from 0) of the connected part of the mesh that it belongs to: elements that share a node are
// connected.
std::vector<Index> connected_parts(const Mesh& mesh, const FiniteElementModel& model);

// What to tell of nodes of different parts that lie at one place (to 1e-9 of the mesh's size), as if a mesh had been put together
// without joining it; empty when there are none. `part`: of connected_parts().
std::string unjoined_parts(const Mesh& mesh, const FiniteElementModel& model, const std::vector<Index>& part);

}  // namespace cbr
