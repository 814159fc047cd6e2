// SPDX-License-Identifier: GPL-3.0-or-later
// Shape functions of the tetrahedra, nodes in Exodus II's order.
#include <array>

#include "common/fem/elements/reference_element.hpp"

namespace cbr {

ShapeFunctions tet4_shape(const Vector3& xi) {
  ShapeFunctions shape{Vector(4), Points::Zero(4, 3)};
  shape.N << 1 - xi.sum(), xi;
  shape.dN.row(0).setConstant(-1);
  shape.dN.bottomRows(3).setIdentity();
  return shape;
}

ShapeFunctions tet10_shape(const Vector3& xi) {
  constexpr std::array<std::array<int, 2>, 6> edges = {
      {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
  const auto [L, dL] = tet4_shape(xi);
  ShapeFunctions shape{Vector(10), Points(10, 3)};
  for (int i = 0; i < 4; ++i) {
    shape.N(i) = L(i) * (2 * L(i) - 1);
    shape.dN.row(i) = (4 * L(i) - 1) * dL.row(i);
  }
  for (int e = 0; e < 6; ++e) {
    const auto [i, j] = edges[static_cast<std::size_t>(e)];
    shape.N(4 + e) = 4 * L(i) * L(j);
    shape.dN.row(4 + e) = 4 * (L(j) * dL.row(i) + L(i) * dL.row(j));
  }
  return shape;
}

}  // namespace cbr
