// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/reference_element.hpp"

#include <array>
#include <cassert>

namespace cbr {
namespace {

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
  QuadratureRule stiffness, mass, corners;
  Vector3 center;
};

QuadratureRule hex_corners() {
  QuadratureRule rule;
  for (const int z : {-1, 1})
    for (const int y : {-1, 1})
      for (const int x : {-1, 1}) rule.push_back({Vector3(x, y, z), 0});
  return rule;
}

QuadratureRule tet_corners() {
  QuadratureRule rule = {{Vector3::Zero(), 0}};
  for (int c = 0; c < 3; ++c) rule.push_back({Vector3::Unit(c), 0});
  return rule;
}

QuadratureRule wedge_corners() {
  QuadratureRule rule;
  for (const int z : {-1, 1})
    for (const auto& [r, s] : {std::pair{0, 0}, {1, 0}, {0, 1}})
      rule.push_back({Vector3(r, s, z), 0});
  return rule;
}

// The Jacobian does not depend on zeta: the base corners speak for the whole edges up to the apex.
QuadratureRule pyramid_corners() {
  QuadratureRule rule;
  for (const int b : {-1, 1})
    for (const int a : {-1, 1}) rule.push_back({Vector3(a, b, 0), 0});
  return rule;
}

Rules rules(ElementType type) {
  switch (type) {
    case ElementType::hex8:
      return {gauss_hex(2), gauss_hex(2), hex_corners(), Vector3::Zero()};
    case ElementType::hex20:
    case ElementType::hex27:
      return {gauss_hex(3), gauss_hex(3), hex_corners(), Vector3::Zero()};
    case ElementType::tet4:
      return {tetrahedron_rule(1), tetrahedron_rule(4), tet_corners(), Vector3::Constant(0.25)};
    case ElementType::tet10:
      return {tetrahedron_rule(14), tetrahedron_rule(14), tet_corners(), Vector3::Constant(0.25)};
    case ElementType::wedge6:
      return {wedge_rule(3, 2), wedge_rule(6, 3), wedge_corners(), Vector3(1.0 / 3, 1.0 / 3, 0)};
    case ElementType::wedge15:
      return {wedge_rule(6, 3), wedge_rule(6, 3), wedge_corners(), Vector3(1.0 / 3, 1.0 / 3, 0)};
    case ElementType::pyramid5:
      return {pyramid_rule(2, 1), pyramid_rule(3, 2), pyramid_corners(), Vector3(0, 0, 0.25)};
    default:
      assert(false && "a volume element");
      return {};
  }
}

ReferenceElement make(ElementType type) {
  if (dimension(type) != 3) return {};
  const Rules rule = rules(type);
  ReferenceElement element{0, tabulate(type, rule.stiffness), tabulate(type, rule.mass),
                           tabulate(type, rule.corners), tabulate(type, {{rule.center, 0}})};
  for (const double weight : element.stiffness.weight) element.volume += weight;
  return element;
}

}  // namespace

ShapeFunctions shape_functions(ElementType type, const Vector3& xi) {
  switch (type) {
    case ElementType::hex8:
      return hex8_shape(xi);
    case ElementType::hex20:
      return hex20_shape(xi);
    case ElementType::hex27:
      return hex27_shape(xi);
    case ElementType::tet4:
      return tet4_shape(xi);
    case ElementType::tet10:
      return tet10_shape(xi);
    case ElementType::wedge6:
      return wedge6_shape(xi);
    case ElementType::wedge15:
      return wedge15_shape(xi);
    case ElementType::pyramid5:
      return pyramid5_shape(xi);
    default:
      assert(false && "a volume element");
      return {};
  }
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
