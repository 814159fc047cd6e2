// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/reference_element.hpp"

#include <array>
#include <cassert>
#include <cmath>
#include <map>

namespace cbr {
namespace {

// All points with barycentric coordinates (1 - k a, a, .., a) permuted, k + 1 corners.
void add_corner_orbit(QuadratureRule& rule, int dimension, double a, double weight) {
  Vector3 base = Vector3::Zero();
  base.head(dimension).setConstant(a);
  rule.push_back({base, weight});
  for (int c = 0; c < dimension; ++c) {
    Vector3 xi = base;
    xi(c) = 1 - dimension * a;
    rule.push_back({xi, weight});
  }
}

// The six points of a tetrahedron with barycentric coordinates (a, a, 1/2 - a, 1/2 - a) permuted.
void add_edge_orbit(QuadratureRule& rule, double a, double weight) {
  const double b = 0.5 - a;
  for (int c = 0; c < 3; ++c) {
    Vector3 one = Vector3::Constant(b), two = Vector3::Constant(a);
    one(c) = a;
    two(c) = b;
    rule.push_back({one, weight});
    rule.push_back({two, weight});
  }
}

ShapeTable tabulate(ElementType type, const QuadratureRule& rule) {
  ShapeTable table;
  table.N.resize(n_nodes(type), static_cast<Index>(rule.size()));
  for (std::size_t q = 0; q < rule.size(); ++q) {
    const ShapeFunctions shape = shape_functions(type, rule[q].xi);
    table.weight.push_back(rule[q].weight);
    table.N.col(static_cast<Index>(q)) = shape.N;
    table.dN.push_back(shape.dN);
  }
  return table;
}

struct Rules {
  QuadratureRule stiffness, mass;
  Vector3 center;
  QuadratureRule reduced = {};
};

Rules rules(ElementType type) {
  switch (type) {
    case ElementType::hex8:
      return {gauss_hex(2), gauss_hex(2), Vector3::Zero()};
    case ElementType::hex20:
      return {gauss_hex(3), gauss_hex(3), Vector3::Zero(), gauss_hex(2)};
    case ElementType::hex27:
      return {gauss_hex(3), gauss_hex(3), Vector3::Zero()};
    case ElementType::tet4:
      return {tetrahedron_rule(1), tetrahedron_rule(4), Vector3::Constant(0.25)};
    case ElementType::tet10:
      return {tetrahedron_rule(14), tetrahedron_rule(14), Vector3::Constant(0.25)};
    case ElementType::wedge6:
      return {wedge_rule(3, 2), wedge_rule(6, 3), Vector3(1.0 / 3, 1.0 / 3, 0)};
    case ElementType::wedge15:
      return {wedge_rule(6, 3), wedge_rule(6, 3), Vector3(1.0 / 3, 1.0 / 3, 0), wedge_rule(3, 3)};
    case ElementType::pyramid5:
      return {pyramid_rule(2, 1), pyramid_rule(3, 2), Vector3(0, 0, 0.25)};
    default:
      assert(false && "a volume element");
      return {};
  }
}

ReferenceElement make(ElementType type) {
  if (dimension(type) != 3) return {};
  const Rules rule = rules(type);
  QuadratureRule corners;
  for (Index a = 0; a < n_corners(type); ++a) corners.push_back({place_of_node(type, a), 0});
  ReferenceElement element{0,
                           tabulate(type, rule.stiffness),
                           tabulate(type, rule.mass),
                           tabulate(type, corners),
                           tabulate(type, {{rule.center, 0}}),
                           tabulate(type, rule.reduced)};
  for (const double weight : element.stiffness.weight) element.volume += weight;
  return element;
}

}  // namespace

std::vector<LinePoint> gauss_line(int n) {
  switch (n) {
    case 1:
      return {{0, 2}};
    case 2:
      return {{-1 / std::sqrt(3.0), 1}, {1 / std::sqrt(3.0), 1}};
    default:
      assert(n == 3);
      return {{-std::sqrt(0.6), 5.0 / 9}, {0, 8.0 / 9}, {std::sqrt(0.6), 5.0 / 9}};
  }
}

QuadratureRule gauss_hex(int n) {
  const auto line = gauss_line(n);
  QuadratureRule rule;
  for (const auto& z : line)
    for (const auto& y : line)
      for (const auto& x : line)
        rule.push_back({Vector3(x.xi, y.xi, z.xi), x.weight * y.weight * z.weight});
  return rule;
}

QuadratureRule triangle_rule(int n_points) {
  QuadratureRule rule;
  if (n_points == 3) {
    add_corner_orbit(rule, 2, 1.0 / 6, 1.0 / 6);
  } else {
    assert(n_points == 6);
    const double root = std::sqrt(38 - 44 * std::sqrt(0.4)),
                 weight_root = std::sqrt(213125 - 53320 * std::sqrt(10.0));
    add_corner_orbit(rule, 2, (8 - std::sqrt(10.0) + root) / 18, (620 + weight_root) / 7440);
    add_corner_orbit(rule, 2, (8 - std::sqrt(10.0) - root) / 18, (620 - weight_root) / 7440);
  }
  return rule;
}

QuadratureRule tetrahedron_rule(int n_points) {
  if (n_points == 1) return {{Vector3::Constant(0.25), 1.0 / 6}};
  QuadratureRule rule;
  if (n_points == 4) {
    add_corner_orbit(rule, 3, (5 - std::sqrt(5.0)) / 20, 1.0 / 24);
  } else {
    assert(n_points == 14);
    add_corner_orbit(rule, 3, 0.31088591926330060980, 0.11268792571801585080 / 6);
    add_corner_orbit(rule, 3, 0.092735250310891226402, 0.073493043116361949544 / 6);
    add_edge_orbit(rule, 0.045503704125649649492, 0.042546020777081466438 / 6);
  }
  return rule;
}

QuadratureRule wedge_rule(int n_triangle, int n_line) {
  QuadratureRule rule;
  for (const auto& z : gauss_line(n_line))
    for (const auto& p : triangle_rule(n_triangle))
      rule.push_back({Vector3(p.xi(0), p.xi(1), z.xi), p.weight * z.weight});
  return rule;
}

QuadratureRule pyramid_rule(int n, int n_zeta) {
  // With t = 1 - zeta the weight is t^2 and the two points are the roots of t^2 - 4 t / 3 + 2 / 5.
  std::vector<LinePoint> heights = {{0.25, 1.0 / 3}};
  if (n_zeta == 2) {
    const double half = std::sqrt(2.0 / 45);
    const double lower = 2.0 / 3 - half, upper = 2.0 / 3 + half;
    heights = {{1 - lower, (upper / 3 - 0.25) / (2 * half)},
               {1 - upper, (0.25 - lower / 3) / (2 * half)}};
  }
  const auto line = gauss_line(n);
  QuadratureRule rule;
  for (const auto& z : heights)
    for (const auto& b : line)
      for (const auto& a : line)
        rule.push_back({Vector3(a.xi, b.xi, z.xi), a.weight * b.weight * z.weight});
  return rule;
}

ShapeFunctions shape_functions(ElementType type, const Vector3& xi) {
  using enum ElementType;
  static const std::map<ElementType, ShapeFunctions (*)(const Vector3&)> all = {
      {tet4, tet4_shape},     {tet10, tet10_shape},     {pyramid5, pyramid5_shape},
      {wedge6, wedge6_shape}, {wedge15, wedge15_shape}, {hex8, hex8_shape},
      {hex20, hex20_shape},   {hex27, hex27_shape}};
  return all.at(type)(xi);
}

Vector3 place_of_node(ElementType type, Index a) {
  constexpr std::array<double, 5> values = {0, 0.5, -0.5, 1, -1};
  for (const double z : values)
    for (const double y : values)
      for (const double x : values) {
        const Vector N = shape_functions(type, Vector3(x, y, z)).N;
        if ((N - Vector::Unit(N.size(), a)).cwiseAbs().maxCoeff() < 1e-12) return {x, y, z};
      }
  assert(false && "a node of a volume element");
  return Vector3::Zero();
}

const ReferenceElement& reference_element(ElementType type) {
  constexpr std::size_t n_types = static_cast<std::size_t>(ElementType::hex27) + 1;
  static const auto table = [] {
    std::array<ReferenceElement, n_types> elements;
    for (std::size_t i = 0; i < n_types; ++i) elements[i] = make(static_cast<ElementType>(i));
    return elements;
  }();
  assert(dimension(type) == 3);
  return table[static_cast<std::size_t>(type)];
}

}  // namespace cbr
