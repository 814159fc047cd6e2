// SPDX-License-Identifier: GPL-3.0-or-later
// Shape functions of the wedge, nodes in Exodus II's order: the triangle at zeta = -1, then the one
// at zeta = 1.
#include "common/fem/elements/reference_element.hpp"

namespace cbr {

ShapeFunctions wedge6_shape(const Vector3& xi) {
  const Vector3 L(1 - xi(0) - xi(1), xi(0), xi(1));
  ShapeFunctions shape{Vector(6), Points(6, 3)};
  for (int i = 0; i < 6; ++i) {
    const int corner = i % 3, side = i < 3 ? -1 : 1;
    const double height = 0.5 * (1 + side * xi(2));
    const double dr = corner == 0 ? -1 : corner == 1, ds = corner == 0 ? -1 : corner == 2;
    shape.N(i) = L(corner) * height;
    shape.dN.row(i) << dr * height, ds * height, 0.5 * side * L(corner);
  }
  return shape;
}

}  // namespace cbr
