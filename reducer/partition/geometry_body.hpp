// SPDX-License-Identifier: GPL-3.0-or-later
// The rigid body that a mesh is as geometry, whatever its mass matrix.
#pragma once

#include <vector>

#include "common/fem/assembly.hpp"
#include "common/mesh/mesh.hpp"

namespace cbr {

// Mass, centre and inertia about it, by the elements' quadrature of rho over their volume.
// `properties`: one per block. Elements are not checked: for meshes that can be assembled, or for
// information only.
RigidBody rigid_body_of_geometry(const Mesh& mesh, const std::vector<BlockProperties>& properties);

}  // namespace cbr
