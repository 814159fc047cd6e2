// SPDX-License-Identifier: GPL-3.0-or-later
// Shape functions of the hexes, nodes in Exodus II's order: corners, edges (bottom, upright, top),
// then for 27 nodes the centre and the faces at -z, +z, -x, +x, -y, +y.
#include <array>

#include "common/fem/elements/reference_element.hpp"

namespace cbr {
namespace {

constexpr std::array<std::array<int, 3>, 27> hex_nodes = {
    {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1},  {1, 1, 1},
     {-1, 1, 1},   {0, -1, -1}, {1, 0, -1}, {0, 1, -1},  {-1, 0, -1}, {-1, -1, 0}, {1, -1, 0},
     {1, 1, 0},    {-1, 1, 0},  {0, -1, 1}, {1, 0, 1},   {0, 1, 1},   {-1, 0, 1},  {0, 0, 0},
     {0, 0, -1},   {0, 0, 1},   {-1, 0, 0}, {1, 0, 0},   {0, -1, 0},  {0, 1, 0}}};

// A function of one coordinate and its derivative.
struct Factor {
  double value, slope;
};

Factor linear(int node, double xi) { return {0.5 * (1 + node * xi), 0.5 * node}; }

Factor quadratic(int node, double xi) {
  if (node == 0) return {1 - xi * xi, -2 * xi};
  return {0.5 * xi * (xi + node), xi + 0.5 * node};
}

template <int n, class Lagrange>
ShapeFunctions tensor_product(const Vector3& xi, Lagrange factor) {
  ShapeFunctions shape{Vector(n), Points(n, 3)};
  for (int i = 0; i < n; ++i) {
    const auto& node = hex_nodes[static_cast<std::size_t>(i)];
    const Factor x = factor(node[0], xi(0)), y = factor(node[1], xi(1)), z = factor(node[2], xi(2));
    shape.N(i) = x.value * y.value * z.value;
    shape.dN.row(i) << x.slope * y.value * z.value, x.value * y.slope * z.value,
        x.value * y.value * z.slope;
  }
  return shape;
}

}  // namespace

ShapeFunctions hex8_shape(const Vector3& xi) { return tensor_product<8>(xi, linear); }
ShapeFunctions hex27_shape(const Vector3& xi) { return tensor_product<27>(xi, quadratic); }

ShapeFunctions hex20_shape(const Vector3& xi) {
  // Edge functions: bubble along the edge, linear across. Corner functions: trilinear minus half of
  // each of the corner's edges.
  ShapeFunctions shape{Vector(20), Points(20, 3)};
  const auto edge = [](int node, double x) {
    return node == 0 ? quadratic(0, x) : linear(node, x);
  };
  const ShapeFunctions all = tensor_product<20>(xi, edge);
  for (int i = 0; i < 20; ++i) {
    shape.N(i) = all.N(i);
    shape.dN.row(i) = all.dN.row(i);
    if (i >= 8) continue;
    const auto& corner = hex_nodes[static_cast<std::size_t>(i)];
    for (int e = 8; e < 20; ++e) {
      const auto& node = hex_nodes[static_cast<std::size_t>(e)];
      bool touches = true;
      for (std::size_t c = 0; c < 3; ++c)
        touches = touches && (node[c] == 0 || node[c] == corner[c]);
      if (!touches) continue;
      shape.N(i) -= 0.5 * all.N(e);
      shape.dN.row(i) -= 0.5 * all.dN.row(e);
    }
  }
  return shape;
}

}  // namespace cbr
