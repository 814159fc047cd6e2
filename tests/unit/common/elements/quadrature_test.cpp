// SPDX-License-Identifier: GPL-3.0-or-later
// Rules against the closed integrals of monomials; shape functions against what defines them.

#include <gtest/gtest.h>

#include "common/fem/elements/reference_element.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::quadrature_test {
namespace {

double factorial(int n) { return std::tgamma(n + 1.0); }
// Integral of t^p over [-1, 1].
double line(int p) { return p % 2 == 0 ? 2.0 / (p + 1) : 0; }

using Exact = std::function<double(int, int, int)>;
using Wanted = std::function<bool(int, int, int)>;

void expect_exact(const QuadratureRule& rule, const Exact& exact, const Wanted& wanted) {
  int count = 0;
  for (const auto& point : rule) EXPECT_GT(point.weight, 0);
  for (int p = 0; p <= 6; ++p)
    for (int q = 0; q <= 6; ++q)
      for (int r = 0; r <= 6; ++r) {
        if (!wanted(p, q, r)) continue;
        double sum = 0;
        for (const auto& [xi, weight] : rule)
          sum += weight * std::pow(xi(0), p) * std::pow(xi(1), q) * std::pow(xi(2), r);
        EXPECT_NEAR(sum, exact(p, q, r), 4e-15) << p << ' ' << q << ' ' << r;
        ++count;
      }
  EXPECT_GT(count, 0);
}

TEST(Quadrature, Hex) {
  for (const int n : {1, 2, 3})
    expect_exact(
        gauss_hex(n), [](int p, int q, int r) { return line(p) * line(q) * line(r); },
        [n](int p, int q, int r) {
          return std::max({p, q, r}) <= 2 * n - 1;
        });
}

TEST(Quadrature, Tetrahedron) {
  for (const auto& [n, degree] : {std::pair{1, 1}, {4, 2}, {14, 5}})
    expect_exact(
        tetrahedron_rule(n),
        [](int p, int q, int r) {
          return factorial(p) * factorial(q) * factorial(r) / factorial(p + q + r + 3);
        },
        [d = degree](int p, int q, int r) { return p + q + r <= d; });
}

TEST(Quadrature, Wedge) {
  for (const auto& [n, degree, n_line] : {std::tuple{3, 2, 2}, {6, 4, 3}})
    expect_exact(
        wedge_rule(n, n_line),
        [](int p, int q, int r) {
          return factorial(p) * factorial(q) / factorial(p + q + 2) * line(r);
        },
        [d = degree, m = 2 * n_line - 1](int p, int q, int r) { return p + q <= d && r <= m; });
}

TEST(Quadrature, Pyramid) {
  // The integral of zeta^r (1 - zeta)^2 over [0, 1] is 2 r! / (r + 3)!.
  for (const auto& [n, n_zeta] : {std::pair{2, 1}, {3, 2}})
    expect_exact(
        pyramid_rule(n, n_zeta),
        [](int p, int q, int r) { return line(p) * line(q) * 2 * factorial(r) / factorial(r + 3); },
        [m = 2 * n - 1, k = 2 * n_zeta - 1](int p, int q, int r) {
          return std::max(p, q) <= m && r <= k;
        });
}

// The reference coordinates of the corners, written down apart from the shape functions.
Points reference_corners(ElementType type) {
  Points X(n_corners(type), 3);
  switch (n_corners(type)) {
    case 4:
      X << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
      break;
    case 5:
      X << -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 1;
      break;
    case 6:
      X << 0, 0, -1, 1, 0, -1, 0, 1, -1, 0, 0, 1, 1, 0, 1, 0, 1, 1;
      break;
    default:
      X << -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1;
  }
  return X;
}

class Shape : public testing::TestWithParam<ElementType> {};

TEST_P(Shape, OneAtItsNodeZeroAtTheOthers) {
  const ElementType type = GetParam();
  const Points nodes = element_points(type, reference_corners(type));
  for (Index i = 0; i < nodes.rows(); ++i)
    EXPECT_LE(
        (shape_functions(type, nodes.row(i).transpose()).N - Vector::Unit(nodes.rows(), i)).norm(),
        1e-14)
        << "node " << i;
}

TEST_P(Shape, SumToOne) {
  const ElementType type = GetParam();
  for (const ShapeTable* table :
       {&reference_element(type).stiffness, &reference_element(type).mass,
        &reference_element(type).center, &reference_element(type).corners})
    for (Index q = 0; q < table->size(); ++q) {
      EXPECT_NEAR(table->N.col(q).sum(), 1, 1e-14);
      EXPECT_LE(table->dN[q].colwise().sum().norm(), 1e-14);
    }
}

TEST_P(Shape, DerivativesAreThoseOfTheFunctions) {
  const ElementType type = GetParam();
  const Vector3 xi(0.21, 0.34, 0.17);
  const ShapeFunctions at = shape_functions(type, xi);
  const double h = 1e-3;
  for (Index c = 0; c < 3; ++c) {
    const auto difference = [&](double step) -> Vector {
      return (shape_functions(type, xi + step * Vector3::Unit(c)).N -
              shape_functions(type, xi - step * Vector3::Unit(c)).N) /
             (2 * step);
    };
    // Richardson: exact for polynomials of degree 4 in one coordinate.
    Vector slope = (4 * difference(h) - difference(2 * h)) / 3;
    if (type == ElementType::pyramid5 && c < 2) slope /= 1 - xi(2);
    EXPECT_LE((slope - at.dN.col(c)).norm(), 1e-11) << "coordinate " << c;
  }
}

TEST_P(Shape, CentreIsTheCentroid) {
  const ElementType type = GetParam();
  const ReferenceElement& reference = reference_element(type);
  const Points X = element_points(type, reference_corners(type));
  Vector N = Vector::Zero(X.rows());
  for (Index q = 0; q < reference.mass.size(); ++q)
    N += reference.mass.weight[q] * reference.mass.N.col(q);
  EXPECT_NEAR(N.sum(), reference.volume, 1e-14 * reference.volume);
  EXPECT_LE((X.transpose() * (N / N.sum() - reference.center.N.col(0))).norm(), 1e-14);
}

INSTANTIATE_TEST_SUITE_P(All, Shape, testing::ValuesIn(volume_types));

}  // namespace
}  // namespace cbr::test::quadrature_test
