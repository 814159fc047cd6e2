// SPDX-License-Identifier: GPL-3.0-or-later
// Stress in shells.
#pragma once

#include "common/fem/elements/shell.hpp"

namespace cbr {

// Cauchy stress (xx yy zz xy yz zx) in the element's middle at the top (along the normal), in the
// middle of the thickness and at the bottom: 3 x 6. u, theta: n x 3, displacements and rotations of
// the nodes. Shear across the thickness is left out: it is 0 at top and bottom.
Matrix shell_stress(ElementType type, const Points& X, const ShellProperties& shell,
                    const Points& u, const Points& theta);

}  // namespace cbr
