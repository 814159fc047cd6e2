// SPDX-License-Identifier: GPL-3.0-or-later
// Shape functions of solids, nodes in Exodus II's order.
#include <array>

#include "common/fem/elements/reference_element.hpp"

namespace cbr {
namespace {

// Hexes: corners, edges (bottom, upright, top), then for 27 nodes the centre and the faces at -z,
// +z, -x, +x, -y, +y.
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

Vector3 barycentric(const Vector3& xi) { return {1 - xi(0) - xi(1), xi(0), xi(1)}; }

// Function i of a wedge, T(L) h(zeta), with the gradient G of T in the barycentric coordinates L.
void set_wedge(ShapeFunctions& shape, int i, double T, const Vector3& G, Factor h) {
  shape.N(i) = T * h.value;
  shape.dN.row(i) << (G(1) - G(0)) * h.value, (G(2) - G(0)) * h.value, T * h.slope;
}

template <int n, class Lagrange>
ShapeFunctions tensor_product(const Vector3& xi, Lagrange factor) {
  ShapeFunctions shape{Vector(n), Points(n, 3)};
  for (int i = 0; i < n; ++i) {
    const auto& node = hex_nodes[i];
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
  const auto edge = [](int node, double x) {
    return node == 0 ? quadratic(0, x) : linear(node, x);
  };
  const ShapeFunctions all = tensor_product<20>(xi, edge);
  ShapeFunctions shape = all;
  for (int i = 0; i < 8; ++i) {
    const auto& corner = hex_nodes[i];
    for (int e = 8; e < 20; ++e) {
      const auto& node = hex_nodes[e];
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

// Tetrahedra.
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
    const auto [i, j] = edges[e];
    shape.N(4 + e) = 4 * L(i) * L(j);
    shape.dN.row(4 + e) = 4 * (L(j) * dL.row(i) + L(i) * dL.row(j));
  }
  return shape;
}

// Wedges: the triangle at zeta = -1, the one at zeta = 1, then the edges of the first, the upright
// ones, those of the second.
ShapeFunctions wedge6_shape(const Vector3& xi) {
  ShapeFunctions shape{Vector(6), Points(6, 3)};
  for (int i = 0; i < 6; ++i)
    set_wedge(shape, i, barycentric(xi)(i % 3), Vector3::Unit(i % 3),
              linear(i < 3 ? -1 : 1, xi(2)));
  return shape;
}

ShapeFunctions wedge15_shape(const Vector3& xi) {
  // Edge functions: bubble along the edge, linear across. Corner functions: those of a tri6 times a
  // linear one, minus half of the upright edge's.
  const Vector3 L = barycentric(xi);
  ShapeFunctions shape{Vector(15), Points(15, 3)};
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, upright = 9 + a;
    const Vector3 e_a = Vector3::Unit(a), e_b = Vector3::Unit(b);
    set_wedge(shape, upright, L(a), e_a, quadratic(0, xi(2)));
    for (const int top : {0, 1}) {
      const int corner = 3 * top + a;
      const Factor height = linear(2 * top - 1, xi(2));
      set_wedge(shape, 6 + 6 * top + a, 4 * L(a) * L(b), 4 * (L(b) * e_a + L(a) * e_b), height);
      set_wedge(shape, corner, L(a) * (2 * L(a) - 1), (4 * L(a) - 1) * e_a, height);
      shape.N(corner) -= 0.5 * shape.N(upright);
      shape.dN.row(corner) -= 0.5 * shape.dN.row(upright);
    }
  }
  return shape;
}

// The pyramid: the base, then the apex.
ShapeFunctions pyramid5_shape(const Vector3& xi) {
  constexpr std::array<std::array<int, 2>, 4> base = {{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  const double a = xi(0), b = xi(1), zeta = xi(2);
  ShapeFunctions shape{Vector(5), Points(5, 3)};
  for (int i = 0; i < 4; ++i) {
    const auto [a_i, b_i] = base[i];
    const double n_a = 0.5 * (1 + a_i * a), n_b = 0.5 * (1 + b_i * b);
    shape.N(i) = (1 - zeta) * n_a * n_b;
    shape.dN.row(i) << 0.5 * a_i * n_b, 0.5 * b_i * n_a, -n_a * n_b;
  }
  shape.N(4) = zeta;
  shape.dN.row(4) << 0, 0, 1;
  return shape;
}

}  // namespace cbr
