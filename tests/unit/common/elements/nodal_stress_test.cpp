// SPDX-License-Identifier: GPL-3.0-or-later
// Stress at nodes: exact for what the elements hold.
#include "common/fem/elements/nodal_stress.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::nodal_stress_test {
namespace {

const Material material = {100, 0.25, 1};

using Stress = Eigen::Matrix<double, 6, 1>;

Stress stress_of(const Matrix3& gradient) {
  const Matrix3 e = 0.5 * (gradient + gradient.transpose());
  const double E = material.youngs_modulus, nu = material.poissons_ratio;
  const Matrix3 s = E / (1 + nu) * (e + nu / (1 - 2 * nu) * e.trace() * Matrix3::Identity());
  return {s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2)};
}

Points motion(const Points& X, const std::function<Vector3(const Vector3&)>& u) {
  Points of_nodes(X.rows(), 3);
  for (Index i = 0; i < X.rows(); ++i) of_nodes.row(i) = u(X.row(i).transpose()).transpose();
  return of_nodes;
}

Matrix3 some_gradient() {
  Matrix3 G;
  G << 0.3, -0.2, 0.5, 0.1, 0.7, -0.4, 0.2, 0.6, -0.9;
  return G;
}

// Skew corners, and for quadratic elements curved edges.
TEST(NodalStress, OfALinearMotionIsTheSameAtEveryNode) {
  for (const ElementKind& c : element_kinds()) {
    Points X = element_points(c.type, skew_corners(c.type));
    Random random(5);
    for (Index i = n_corners(c.type); i < X.rows(); ++i)
      for (Index d = 0; d < 3; ++d) X(i, d) += 0.03 * random();
    const Matrix3 G = some_gradient();
    const Matrix found = element_nodal_stress(
        c.type, c.hex, X, material,
        motion(X, [&](const Vector3& x) { return Vector3(G * x + Vector3(5, -7, 9)); }));
    ASSERT_EQ(found.rows(), X.rows());
    const Stress expected = stress_of(G);
    for (Index i = 0; i < found.rows(); ++i)
      EXPECT_LT((found.row(i).transpose() - expected).norm(), 1e-11 * expected.norm())
          << name(c.type) << ", node " << i;
  }
}

// Of a motion of second degree the stress is linear, and straight quadratic elements hold it.
TEST(NodalStress, OfAQuadraticMotionIsExactInStraightQuadraticElements) {
  const Matrix3 G = some_gradient();
  const auto u = [&](const Vector3& x) {
    return Vector3(G * x + Vector3(x[0] * x[1] - x[2] * x[2], 2 * x[0] * x[0] + x[1] * x[2],
                                   x[0] * x[2] - x[1] * x[1]));
  };
  const auto gradient = [&](const Vector3& x) {
    Matrix3 H;
    H << x[1], x[0], -2 * x[2], 4 * x[0], x[2], x[1], x[2], -2 * x[1], x[0];
    return Matrix3(G + H);
  };
  for (const ElementType type :
       {ElementType::tet10, ElementType::wedge15, ElementType::hex20, ElementType::hex27}) {
    const Mesh mesh =
        box_mesh(type, {1, 1, 1}, Vector3(1, 0.7, 1.3), [](const Vector3& x) -> Vector3 {
          return Vector3(x(0) + 0.2 * x(1), x(1) - 0.1 * x(2), x(2) + 0.3 * x(0));
        });
    const Points X = points_of(mesh, mesh.blocks[0], 0);
    const Matrix found =
        element_nodal_stress(type, HexFormulation::full, X, material, motion(X, u));
    for (Index i = 0; i < X.rows(); ++i) {
      const Stress expected = stress_of(gradient(X.row(i).transpose()));
      EXPECT_LT((found.row(i).transpose() - expected).norm(), 1e-11 * expected.norm())
          << name(type) << ", node " << i;
    }
  }
}

// One brick of the incompatible formulation bends as a beam does: sigma_xx = E k y and nothing
// else, for any shape of rectangle. The bricks of the full formulation show shear that is not
// there.
TEST(NodalStress, OfPureBendingIsExactInTheIncompatibleBrick) {
  const double k = 0.01, nu = material.poissons_ratio;
  const Mesh mesh = box_mesh(
      ElementType::hex8, {1, 1, 1}, Vector3(4, 1, 0.5),
      [](const Vector3& x) -> Vector3 { return Vector3(x(0) - 2, x(1) - 0.5, x(2) - 0.25); });
  const Points X = points_of(mesh, mesh.blocks[0], 0);
  const auto u = [&](const Vector3& x) {
    return Vector3(k * x[0] * x[1], -0.5 * k * (x[0] * x[0] + nu * (x[1] * x[1] - x[2] * x[2])),
                   -nu * k * x[1] * x[2]);
  };
  const Matrix found = element_nodal_stress(ElementType::hex8, HexFormulation::incompatible, X,
                                            material, motion(X, u));
  const Matrix full =
      element_nodal_stress(ElementType::hex8, HexFormulation::full, X, material, motion(X, u));
  for (Index i = 0; i < 8; ++i) {
    const Stress expected = material.youngs_modulus * k * X(i, 1) * Stress::Unit(0);
    EXPECT_LT((found.row(i).transpose() - expected).norm(), 1e-12 * expected.norm());
    EXPECT_GT((full.row(i).transpose() - expected).norm(), 0.1 * expected.norm());
  }
}

}  // namespace
}  // namespace cbr::test::nodal_stress_test
