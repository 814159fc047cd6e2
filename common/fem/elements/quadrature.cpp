// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/quadrature.hpp"

#include <cassert>
#include <cmath>

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

}  // namespace cbr
