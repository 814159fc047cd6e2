// SPDX-License-Identifier: GPL-3.0-or-later
// The faces and node sets that a superelement takes along.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

// Keeps, re-indexed to interface nodes, every sideset and nodeset of the mesh whose nodes are all
// interface nodes: those that were named as interface, and those that lie inside it, as a face's
// set does when the whole surface is the interface. `place`: mesh node -> interface node, -1 for
// the others. Sidesets of shells have no faces of volume elements and are left out unless they were
// named (InputError from extract_surface).
void add_interface_sets(const Mesh& mesh, const std::vector<Index>& place,
                        const std::vector<std::string>& named, Superelement& superelement);

}  // namespace cbr
