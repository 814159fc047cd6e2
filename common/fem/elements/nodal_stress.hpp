// SPDX-License-Identifier: GPL-3.0-or-later
// Stress at the nodes of an element, extrapolated from the points where it is accurate.
#pragma once

#include "common/fem/elements/element.hpp"
#include "common/fem/elements/shell.hpp"

namespace cbr {

// Cauchy stress (xx yy zz xy yz zx) at each node, n x 6, for nodal displacements u (n x 3). It is
// linear in u. The stresses at the sampling points are extrapolated by the polynomial that has as
// many terms as there are points (Hinton and Campbell 1974, doi 10.1002/nme.1620080303; for
// quadratic elements the points of Barlow 1976, doi 10.1002/nme.1620100202):
//   hex8      2 x 2 x 2, trilinear; with the condensed modes of hex8-incompatible; of
//             hex8-hourglass and reduced: one stress
//   hex20/27  2 x 2 x 2, trilinear
//   tet4      one stress
//   tet10     4, linear
//   wedge6/15 3 x 2, linear in the triangle times linear along the axis
//   pyramid5  2 x 2, bilinear in the base's coordinates; their mean at the apex
Matrix element_nodal_stress(ElementType type, HexFormulation hex, const Points& X,
                            const Material& material, const Points& u);

// Cauchy stress (xx yy zz xy yz zx) in the element's middle at the top (along the normal) and at
// the bottom, 12 x 6 n: of displacements of the nodes, x y z of each, then of their rotations.
// Shear across the thickness is left out: it is 0 at top and bottom.
Matrix shell_stress(ElementType type, const Points& X, const ShellProperties& shell);

}  // namespace cbr
