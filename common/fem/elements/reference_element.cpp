// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/reference_element.hpp"

#include <array>
#include <cassert>
#include <map>

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
