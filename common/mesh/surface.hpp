// SPDX-License-Identifier: GPL-3.0-or-later
// A sideset as faces: superelements keep them, the skinner makes shells of them, contact uses them.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace cbr {

struct Surface {
  std::string name;
  FaceKind kind = FaceKind::quad4;
  // f x n_nodes(kind), outward by the right-hand rule; indices into the owner's nodes. A triangle
  // in a set of quad4 repeats its last node.
  IndexTable faces;
  std::vector<Index> element;  // f, element ids in the mesh
  std::vector<int> side;       // f, from 1, as Exodus II

  Index n_faces() const { return faces.rows(); }
};

// Faces of a sideset, indices into mesh.coordinates, in the sideset's order.
// InputError: mixed 6-, 8- and 9-node faces, or a side of an element that is not a volume.
Surface extract_surface(const Mesh& mesh, const Sideset& sideset);

// The surface's nodes, ascending and unique.
std::vector<Index> surface_nodes(const Surface& surface);

// Faces cut into linear ones (quad8 -> 4 corner tri3 + 1 quad4; quad9 -> 4 quad4; tri6 -> 4 tri3):
// contact's view. `parent` is the face's row.
struct LinearFaces {
  IndexTable faces;           // f' x 4; a triangle repeats its last node
  std::vector<Index> parent;  // f'
};
LinearFaces linear_faces(const Surface& surface);

}  // namespace cbr
