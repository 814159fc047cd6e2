// SPDX-License-Identifier: GPL-3.0-or-later
// Recovery data of some elements alone, and the names of what is recovered.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

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
