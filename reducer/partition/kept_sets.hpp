// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene asks of a superelement's sets, held against the mesh before anything is reduced.
#pragma once

#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

// InputError: a set that boundary, contact or output.history name of an instance that stands as the
// component's superelement, and that the mesh does not have or whose nodes the interface does not
// all keep; a traction on a nodeset.
void check_kept_sets(const Scene& scene, const Component& component, const Mesh& mesh);
// The same for a superelement that need not be made: the mesh is read where a set is not in `file`.
void check_kept_sets(const Scene& scene, const Component& component, const Superelement& file);

}  // namespace cbr
