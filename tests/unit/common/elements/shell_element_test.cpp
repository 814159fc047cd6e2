// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/fem/elements/shell.hpp"
#include "common/linalg/dense.hpp"
#include "tests/support/shell_mesh.hpp"

namespace cbr::test::shell_element_test {
namespace {

const Material steel = {210e9, 0.3, 7850};

Matrix3 tilt() {
  return (Eigen::AngleAxisd(0.7, Vector3(1, 2, -0.5).normalized())).toRotationMatrix();
}

Points flat(ElementType type) {
  Points X(n_nodes(type), 3);
  if (type == ElementType::tri3)
    X << 0, 0, 0, 1.2, 0.1, 0, 0.3, 0.8, 0;
  else
    X << 0, 0, 0, 1.2, 0.1, 0, 1.0, 0.9, 0, -0.1, 0.7, 0;
  return X;
}

Points warped() {
  Points X = flat(ElementType::quad4);
  X.col(2) << 0.05, -0.07, 0.06, -0.02;
  return X;
}

Points rotated(const Points& X, const Matrix3& Q) { return X * Q.transpose(); }

// Rigid motions with the element's order of dofs: node by node.
Matrix element_rigid_modes(const Points& X) {
  const Matrix R = shell_rigid_modes(X);
  const Index n = X.rows();
  Matrix E(6 * n, 6);
  for (Index i = 0; i < n; ++i)
    for (int c = 0; c < 6; ++c) E.row(6 * i + c) = R.row(shell_dof(n, i, c));
  return E;
}

Matrix element_rotation(Index n, const Matrix3& Q) {
  Matrix T = Matrix::Zero(6 * n, 6 * n);
  for (Index b = 0; b < 2 * n; ++b) T.block<3, 3>(3 * b, 3 * b) = Q;
  return T;
}

// Rotations weighted by the length, so that all entries of K are of one unit.
Matrix scaled(Matrix K, double length) {
  for (Index i = 0; i < K.rows(); ++i)
    if (i % 6 >= 3) {
      K.row(i) /= length;
      K.col(i) /= length;
    }
  return K;
}

class ShellElement : public testing::TestWithParam<ElementType> {
 protected:
  ElementType type = GetParam();
  std::vector<Points> shapes() const {
    std::vector<Points> all = {flat(type), rotated(flat(type), tilt())};
    if (type == ElementType::quad4) all.push_back(rotated(warped(), tilt()));
    return all;
  }
};

TEST_P(ShellElement, StiffnessIsSymmetricToTheLastBit) {
  for (const Points& X : shapes()) {
    const Matrix K = shell_stiffness(type, X, {steel, 0.01});
    EXPECT_EQ(K, Matrix(K.transpose()));
  }
}

TEST_P(ShellElement, SixRigidMotionsAndNoOther) {
  for (const Points& X : shapes())
    for (const double t : {3.0, 0.1, 1e-3}) {
      const Matrix K = shell_stiffness(type, X, {steel, t});
      EXPECT_LE((K * element_rigid_modes(X)).cwiseAbs().maxCoeff(),
                1e-14 * K.cwiseAbs().maxCoeff());
      const Vector lambda = symmetric_eigenvalues(K);
      const double bending = std::min(1.0, t * t);
      EXPECT_LE(lambda.head(6).cwiseAbs().maxCoeff(), 1e-14 * lambda.maxCoeff());
      EXPECT_GE(lambda(6), 1e-3 * bending * lambda.maxCoeff()) << t;
    }
}

// Along the axes nothing mixes: bending keeps its digits and its rank for any thickness.
TEST_P(ShellElement, ThinShellsKeepTheirBending) {
  const Index n = n_nodes(type);
  std::vector<Index> plate;
  for (Index i = 0; i < 6 * n; ++i)
    if (i % 6 >= 2 && i % 6 <= 4) plate.push_back(i);
  const auto bending = [&](double t) -> Matrix {
    return shell_stiffness(type, flat(type) * 2.5e-3, {steel, t})(plate, plate);
  };
  const Matrix reference = bending(2.5e-8);
  for (const double t : {2.5e-10, 2.5e-14, 2.5e-60}) {
    const Matrix K = bending(t) * std::pow(2.5e-8 / t, 3);
    EXPECT_LE((K - reference).cwiseAbs().maxCoeff(), 1e-9 * reference.cwiseAbs().maxCoeff()) << t;
  }
  Matrix K = reference;
  for (Index i = 0; i < K.rows(); ++i)
    if (i % 3 > 0) {
      K.row(i) /= 2.5e-3;
      K.col(i) /= 2.5e-3;
    }
  const Vector lambda = symmetric_eigenvalues(K);
  EXPECT_LE(lambda.head(3).cwiseAbs().maxCoeff(), 1e-14 * lambda.maxCoeff());
  EXPECT_GE(lambda(3), 1e-3 * lambda.maxCoeff());
}

TEST_P(ShellElement, ScaleFree) {
  const Matrix K = scaled(shell_stiffness(type, shapes().back(), {steel, 0.03}), 1);
  for (const double s : {1e-6, 1e3, 1e40}) {
    const Matrix same =
        scaled(shell_stiffness(type, shapes().back() * s, {steel, 0.03 * s}), s) / s;
    EXPECT_LE((same - K).cwiseAbs().maxCoeff(), 1e-13 * K.cwiseAbs().maxCoeff()) << s;
  }
}

TEST_P(ShellElement, TurnsWithTheAxes) {
  const Points X = shapes().back();
  const Matrix3 Q = (Eigen::AngleAxisd(2.1, Vector3(-1, 0.3, 0.8).normalized())).toRotationMatrix();
  const Matrix T = element_rotation(X.rows(), Q);
  const ShellProperties shell = {steel, 0.05};
  const Matrix K = T * shell_stiffness(type, X, shell) * T.transpose();
  EXPECT_LE((shell_stiffness(type, rotated(X, Q), shell) - K).cwiseAbs().maxCoeff(),
            1e-13 * K.cwiseAbs().maxCoeff());
}

// A mirror turns rotations the other way; the order of the nodes may start anywhere and run either
// way round.
TEST_P(ShellElement, MirrorsAndRenumbers) {
  const Points X = shapes().back();
  const Index n = X.rows();
  const ShellProperties shell = {steel, 0.05};
  const Matrix K = shell_stiffness(type, X, shell);
  const double tolerance = 1e-13 * K.cwiseAbs().maxCoeff();
  Matrix T = element_rotation(n, Vector3(-1, 1, 1).asDiagonal());
  for (Index i = 0; i < n; ++i) T.block<3, 3>(6 * i + 3, 6 * i + 3) *= -1;
  EXPECT_LE((shell_stiffness(type, rotated(X, Vector3(-1, 1, 1).asDiagonal()), shell) - T * K * T)
                .cwiseAbs()
                .maxCoeff(),
            tolerance);
  for (Index start = 0; start < n; ++start)
    for (const Index step : {Index(1), n - 1}) {
      Points Y(n, 3);
      std::vector<Index> dofs;
      for (Index i = 0; i < n; ++i) {
        const Index from = (start + i * step) % n;
        Y.row(i) = X.row(from);
        for (Index c = 0; c < 6; ++c) dofs.push_back(6 * from + c);
      }
      const Matrix same = K(dofs, dofs);
      EXPECT_LE((shell_stiffness(type, Y, shell) - same).cwiseAbs().maxCoeff(), tolerance)
          << start << ' ' << step;
    }
}

TEST_P(ShellElement, MassIsThatOfThePlate) {
  const double area = type == ElementType::tri3 ? 0.465 : 0.885;
  for (const Points& X : {flat(type), rotated(flat(type), tilt())})
    for (const double t : {1e-9, 2.0}) {
      const ShellMass lumped = shell_lumped_mass(type, X, {steel, t});
      EXPECT_NEAR(lumped.mass.sum() / (7850 * t * area), 1, 1e-14);
      EXPECT_GT(lumped.mass.minCoeff(), 0.15 * lumped.mass.sum());
      EXPECT_GE((lumped.rotary.array() / lumped.mass.array()).minCoeff(), t * t / 12);
    }
}

INSTANTIATE_TEST_SUITE_P(Shells, ShellElement,
                         testing::Values(ElementType::tri3, ElementType::quad4));

// Pure bending in its plane of a rectangle of any shape: the incompatible modes, and rotations that
// follow, are exact.
TEST(ShellElementMembrane, RectangleBendsInItsPlane) {
  const double a = 5, b = 0.5, nu = 0.3, kappa = 0.02, t = 0.1;
  Points X(4, 3);
  X << 0, 0, 0, a, 0, 0, a, b, 0, 0, b, 0;
  Vector u = Vector::Zero(24);
  for (Index i = 0; i < 4; ++i) {
    const double x = X(i, 0) - a / 2, y = X(i, 1) - b / 2;
    u(6 * i) = -kappa * x * y;
    u(6 * i + 1) = kappa / 2 * (x * x + nu * y * y);
    u(6 * i + 5) = kappa * x;
  }
  const Matrix K = shell_stiffness(ElementType::quad4, X, {{steel.youngs_modulus, nu, 1}, t});
  const double exact = steel.youngs_modulus * t * b * b * b / 12 * kappa * kappa * a;
  EXPECT_NEAR(u.dot(K * u) / exact, 1, 1e-12);
}

TEST(ShellElementBending, WarpedQuadIsSoundWhenThin) {
  const Points X = rotated(warped(), tilt());
  for (const double t : {1e-4, 1e-8, 1e-12}) {
    const Matrix K =
        shell_stiffness(ElementType::quad4, X, {steel, t}) / (steel.youngs_modulus * t);
    EXPECT_TRUE(K.allFinite());
    EXPECT_LE((K * element_rigid_modes(X)).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_GE(symmetric_eigenvalues(K).minCoeff(), -1e-14);
  }
}

}  // namespace
}  // namespace cbr::test::shell_element_test
