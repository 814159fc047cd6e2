// SPDX-License-Identifier: GPL-3.0-or-later
// Fictitious shells on a surface: K and M on the surface's own nodes, with three rotations for
// each.
#pragma once

#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/fem/assembly.hpp"
#include "common/fem/elements/shell.hpp"

namespace cbr {

// m nodes with shells. Dofs: 3 i + c translations (i = 0 .. m - 1), then 3 m + 3 i + c rotations.
struct ShellModel {
  // m, ascending: indices into the points that assemble_shells() was given
  std::vector<Index> nodes;
  // 6 m x 6 m, or 3 m x 3 m without rotations; 0 x 0 when the shells have no stiffness
  SparseMatrix K;
  Vector mass;    // m; empty when the shells have none
  Vector rotary;  // m, > 0; empty without rotations
  bool has_rotations() const { return rotary.size() > 0; }
  bool empty() const { return K.size() == 0 && mass.size() == 0; }
};

// faces: f x 4, a triangle repeats its last node; each face once (one given twice is two shells). A
// modulus and density (or a thickness) of zero, or products with the thickness that underflow, give
// an empty model. Stiffness without density: the rotations would have no inertia, so they are
// condensed statically, which fills K (for at most 5000 nodes); density without stiffness: there
// are none. InputError: a degenerate face, by its nodes' row numbers; a parameter out of range, or
// so large that an entry overflows.
ShellModel assemble_shells(const IndexTable& faces, const Points& points,
                           const ShellProperties& shell);

// What to tell of shells that hold together and share nodes with solids on one line only, about
// which they turn; empty when there are none.
std::string hinged_shells(const Mesh& mesh, const FiniteElementModel& model);

}  // namespace cbr
