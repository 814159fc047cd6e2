// SPDX-License-Identifier: GPL-3.0-or-later
// Orthotropic elasticity: as isotropic where the constants are, Hooke's law in the material's axes,
// turned axes as a turned body.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/fem/elements/element.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::orthotropic_test {
namespace {

Matrix3 turned() {
  return Matrix3(Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized())).transpose();
}

// A carbon fibre ply, GPa.
Material ply(const Matrix3& axes) {
  return {140, 0, 1600, Orthotropy{{140, 10, 9}, {0.3, 0.4, 0.25}, {5, 3.5, 4.5}, axes}};
}

// Hooke's law written out by compliances, in the material's axes.
Matrix3 strain_of(const Orthotropy& of, const Matrix3& stress) {
  const Matrix3 s = of.axes * stress * of.axes.transpose();
  const Vector3 &E = of.youngs_moduli, &nu = of.poissons_ratios, &G = of.shear_moduli;
  Matrix3 e;
  e(0, 0) = s(0, 0) / E[0] - nu[0] / E[0] * s(1, 1) - nu[2] / E[0] * s(2, 2);
  e(1, 1) = s(1, 1) / E[1] - nu[0] / E[0] * s(0, 0) - nu[1] / E[1] * s(2, 2);
  e(2, 2) = s(2, 2) / E[2] - nu[2] / E[0] * s(0, 0) - nu[1] / E[1] * s(1, 1);
  e(0, 1) = e(1, 0) = s(0, 1) / (2 * G[0]);
  e(1, 2) = e(2, 1) = s(1, 2) / (2 * G[1]);
  e(0, 2) = e(2, 0) = s(0, 2) / (2 * G[2]);
  return of.axes.transpose() * e * of.axes;
}

Points box(ElementType type) {
  const Mesh mesh = box_mesh(type, {1, 1, 1}, Vector3(1, 0.7, 1.3));
  return points_of(mesh, mesh.blocks[0], 0);
}

TEST(Orthotropic, IsotropicConstantsGiveTheIsotropicMatrix) {
  const double E = 210, nu = 0.3, G = E / (2 * (1 + nu));
  for (const auto& [type, hex] : element_kinds()) {
    const Points X = element_points(type, skew_corners(type));
    const Matrix K = element_stiffness(type, hex, X, {E, nu, 1});
    const Matrix same = element_stiffness(
        type, hex, X, {E, 0, 1, Orthotropy{{E, E, E}, {nu, nu, nu}, {G, G, G}, turned()}});
    EXPECT_LT((K - same).cwiseAbs().maxCoeff(), 1e-13 * K.cwiseAbs().maxCoeff()) << name(type);
    EXPECT_EQ(same, Matrix(same.transpose())) << name(type);
  }
}

// A linear motion: the stress is that of Hooke's law, and the work of the nodal forces is that of
// stress and strain.
TEST(Orthotropic, StressAndEnergyOfAConstantStrain) {
  const Material material = ply(turned());
  Matrix3 stress;
  stress << 3, 0.5, -0.4, 0.5, -1, 0.7, -0.4, 0.7, 2;
  const Matrix3 strain = strain_of(*material.orthotropy, stress);
  for (const auto& [type, hex] : element_kinds()) {
    const Points X = box(type);
    const Points u = X * strain;
    const Eigen::Matrix<double, 6, 1> found = element_stress(type, hex, X, material, u);
    const Eigen::Matrix<double, 6, 1> expected{3, -1, 2, 0.5, 0.7, -0.4};
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-12) << name(type);
    const Vector forces =
        element_stiffness(type, hex, X, material) * Eigen::Map<const Vector>(u.data(), u.size());
    const double volume = element_mass(type, X, 1).sum();
    EXPECT_NEAR(forces.dot(Eigen::Map<const Vector>(u.data(), u.size())),
                volume * stress.cwiseProduct(strain).sum(), 1e-12)
        << name(type);
  }
}

// Turned axes in a body at rest are the same as axes at rest in a body that is turned back.
TEST(Orthotropic, TurnedAxesAreATurnedBody) {
  const Matrix3 Q = turned();
  for (const auto& [type, hex] : element_kinds()) {
    // its coefficient is a bound along the component's axes
    if (hex == HexFormulation::hourglass || hex == HexFormulation::reduced) continue;
    const Points X = element_points(type, skew_corners(type));
    const Matrix K = element_stiffness(type, hex, X, ply(Q));
    const Matrix in_own = element_stiffness(type, hex, X * Q.transpose(), ply(Matrix3::Identity()));
    Matrix back(K.rows(), K.cols());
    for (Index i = 0; i < X.rows(); ++i)
      for (Index j = 0; j < X.rows(); ++j)
        back.block<3, 3>(3 * i, 3 * j) = Q.transpose() * in_own.block<3, 3>(3 * i, 3 * j) * Q;
    EXPECT_LT((K - back).cwiseAbs().maxCoeff(), 1e-12 * K.cwiseAbs().maxCoeff()) << name(type);
  }
}

}  // namespace
}  // namespace cbr::test::orthotropic_test
