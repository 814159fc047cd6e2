// SPDX-License-Identifier: GPL-3.0-or-later
// Shape functions of the pyramid, nodes in Exodus II's order: the base, then the apex.
#include <array>

#include "common/fem/elements/reference_element.hpp"

namespace cbr {

ShapeFunctions pyramid5_shape(const Vector3& xi) {
  constexpr std::array<std::array<int, 2>, 4> base = {{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  const double a = xi(0), b = xi(1), zeta = xi(2);
  ShapeFunctions shape{Vector(5), Points(5, 3)};
  for (int i = 0; i < 4; ++i) {
    const auto [a_i, b_i] = base[static_cast<std::size_t>(i)];
    const double n_a = 0.5 * (1 + a_i * a), n_b = 0.5 * (1 + b_i * b);
    shape.N(i) = (1 - zeta) * n_a * n_b;
    shape.dN.row(i) << 0.5 * a_i * n_b, 0.5 * b_i * n_a, -n_a * n_b;
  }
  shape.N(4) = zeta;
  shape.dN.row(4) << 0, 0, 1;
  return shape;
}

}  // namespace cbr
