// SPDX-License-Identifier: GPL-3.0-or-later
// Boxes of all element types, curved by a map, and the same boxes with other numbers.
#pragma once

#include <array>
#include <functional>

#include "common/mesh/mesh.hpp"

namespace cbr::test {

// The elements of every other column of cells.
struct CellKind {
  ElementType even = ElementType::hex8, odd = even;
  bool operator==(const CellKind&) const = default;
};

struct LatticeShape {
  CellKind kind;
  std::array<Index, 3> n{1, 1, 1};
  Vector3 size = Vector3::Ones();
  // of all nodes including mid-edge ones: edges are curved
  std::function<Vector3(const Vector3&)> map = {};
};

// A box from the origin: each of its n cells is a hex, six tets, two wedges or six pyramids. Blocks
// "low" and "high" are halves along x, one per element type ("low_hex8", ... if there are two).
// Sidesets x_min, ..., z_max. Nodesets end (the nodes of x_max), three (three nodes of x_max that
// constrain a body) and one (a corner).
Mesh lattice_mesh(const LatticeShape& shape);

// The same body with nodes, elements, blocks of one kind and sides in random order, other ids, and
// another first corner of each element.
Mesh renumbered_any(const Mesh& mesh, unsigned seed);

}  // namespace cbr::test
