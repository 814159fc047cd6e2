// SPDX-License-Identifier: GPL-3.0-or-later
// Nodal forces of a uniform traction on faces, and the nodes of each face.
#pragma once

#include "common/base/types.hpp"
#include "common/mesh/surface.hpp"

namespace cbr {

// Of a face of the surface: 3, 4, 6, 8 or 9 nodes, corners first. A triangle in a set of quads
// is one of fewer nodes than the row of `faces` has.
std::vector<Index> nodes_of_face(const Surface& surface, Index face);

// Integral of each node's shape function over the surface (n_nodes, area units; sums to the area):
// a uniform traction t on the faces is the nodal forces t x weights. Exact for flat parallelograms
// and triangles of both orders; 3 x 3 Gauss points on other quads.
Vector face_weights(const Surface& surface, const Points& coordinates);

// The same of shape functions times the outward normal (n_nodes x 3): a uniform pressure p on the
// faces is the nodal forces -p x these.
Points face_normals(const Surface& surface, const Points& coordinates);

// Integral of N_i N_j over the surface (n_nodes x n_nodes, area units): M psi are the nodal forces
// of a pressure whose values at the nodes are psi. Exact as above.
SparseMatrix face_mass(const Surface& surface, const Points& coordinates);

}  // namespace cbr
