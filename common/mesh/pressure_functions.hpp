// SPDX-License-Identifier: GPL-3.0-or-later
// Few pressures on a surface: the unknowns of contact where a face closes as a whole.
#pragma once

#include <vector>

#include "common/base/types.hpp"
#include "common/mesh/surface.hpp"

namespace cbr {

// Functions Psi on the nodes of a surface, not negative, that add up to one at every node; and the
// nodal forces N = M Psi of unit pressures of these shapes, M the faces' mass matrix. So a uniform
// pressure is exact on faces of every order, and an impulse on the functions that their cone allows
// is a pressure that every node may have.
struct PressureFunctions {
  std::vector<Index> nodes;  // m, ascending, of the owner
  // m x k, area units. A node on a sharp edge has entries of the functions on both sides.
  SparseMatrix N;
  // Of each entry of N, in its order: the cell that its node belongs to on the function's side of
  // sharp edges. Function a has cell a.
  std::vector<Index> entry_cell;
  // Of corner_functions(): the values of Psi (m x k), and integrals of each times the outward
  // normal (k x 3).
  SparseMatrix Psi;
  Points normals = Points(0, 3);

  Index size() const { return N.cols(); }
};

// About `wanted` functions: aggregates of nodes around seeds that are far from each other, smoothed
// by averages over neighbours about half an aggregate's radius far, as in smoothed aggregation
// (Vanek, Mandel, Brezina 1996, doi 10.1007/BF02238511). No function reaches over an edge that is
// sharper than 20 degrees.
// Precondition: wanted >= 1; `faces` have at least one face.
PressureFunctions pressure_functions(const std::vector<Surface>& faces, const Points& coordinates,
                                     Index wanted);

// One function for each corner of the faces, linear between the corners: of faces of second order
// the most functions of which a pressure that is not negative has nodal forces that may be. None
// reaches over an edge that is sharper than 20 degrees. `faces`: as above.
PressureFunctions corner_functions(const std::vector<Surface>& faces, const Points& coordinates);

}  // namespace cbr
