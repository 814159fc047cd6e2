// SPDX-License-Identifier: GPL-3.0-or-later
// The faces and node sets that a superelement takes along, what a scene asks of them, and what
// recovery data keep of them.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

// Keeps, re-indexed to interface nodes, every sideset and nodeset of the mesh whose nodes are all
// interface nodes: those that were named as interface, and those that lie inside it, as a face's
// set does when the whole surface is the interface. `place`: mesh node -> interface node, -1 for
// the others. Sidesets of shells have no faces of volume elements and are left out unless they were
// named (InputError from extract_surface).
void add_interface_sets(const Mesh& mesh, const std::vector<Index>& place,
                        const std::vector<std::string>& named, Superelement& superelement);

// InputError: a set that boundary, contact or output.history name of an instance that stands as the
// component's superelement, and that the mesh does not have or whose nodes the interface does not
// all keep; a traction on a nodeset.
void check_kept_sets(const Scene& scene, const Component& component, const Mesh& mesh);
// The same for a superelement that need not be made: the mesh is read where a set is not in `file`.
void check_kept_sets(const Scene& scene, const Component& component, const Superelement& file);

// InputError: reduction.recovery names a set or block that the mesh does not have.
void check_recovery_sets(const Mesh& mesh, const ReductionOptions& reduction);

// Leaves the elements that meet a node of these sets or are of these blocks, and the rows of their
// interior nodes. `recovery`: whole; `place`: of a mesh node in [interface nodes; interior nodes],
// or -1. All blocks stay, some without elements.
void keep_elements_at(const Mesh& mesh, const std::vector<std::string>& names,
                      const std::vector<Index>& place, Superelement::Recovery& recovery);

// Fills recovered_sets: sidesets and nodesets of the component's mesh that have all their nodes in
// the superelement. Of a domain: the nodes of each set that it has. Nothing without recovery data.
void add_recovered_sets(const Mesh& mesh, bool is_domain, Superelement& superelement);

}  // namespace cbr
