// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/element.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/base/error.hpp"
#include "common/fem/assembly.hpp"
#include "common/linalg/dense.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::element_test {
namespace {

const Material steel = {210e9, 0.3, 7850};

// Skew corners, and for quadratic elements curved edges and faces.
Points distorted(ElementType type) {
  Points X = element_points(type, skew_corners(type));
  Random random(7);
  for (Index i = n_corners(type); i < X.rows(); ++i)
    for (Index c = 0; c < 3; ++c) X(i, c) += 0.04 * random();
  return X;
}

// A parallelepiped, or the part of one.
Points affine(ElementType type) {
  const Mesh mesh =
      box_mesh(type, {1, 1, 1}, Vector3(1, 0.7, 1.3), [](const Vector3& x) -> Vector3 {
        return Vector3(x(0) + 0.2 * x(1), x(1) - 0.1 * x(2), x(2) + 0.3 * x(0));
      });
  return points_of(mesh, mesh.blocks[0], 0);
}

class Element : public testing::TestWithParam<ElementKind> {
 protected:
  ElementType type = GetParam().type;
  HexFormulation hex = GetParam().hex;
  Matrix stiffness(const Points& X, const Material& material = steel) const {
    return element_stiffness(type, hex, X, material);
  }
};

TEST_P(Element, StiffnessIsSymmetricToTheLastBit) {
  const Matrix K = stiffness(distorted(type));
  EXPECT_EQ(K, Matrix(K.transpose()));
}

TEST_P(Element, RigidMotionsNeedNoForceAndNothingElseDoes) {
  for (const Points& X : {affine(type), distorted(type)}) {
    const Matrix K = stiffness(X);
    const Matrix R = rigid_modes(X, X.colwise().mean().transpose());
    EXPECT_LE((K * R).cwiseAbs().maxCoeff(),
              1e-14 * K.cwiseAbs().maxCoeff() * static_cast<double>(K.rows()));
    const Vector lambda = symmetric_eigenvalues(K);
    EXPECT_LE(lambda.head(6).cwiseAbs().maxCoeff(), 1e-13 * lambda.maxCoeff());
    EXPECT_GE(lambda(6), 1e-4 * lambda.maxCoeff());
  }
}

TEST_P(Element, NearlyIncompressibleAndNoPoissonAreFinite) {
  for (const double nu : {0.0, 0.4999, -0.9}) {
    const Matrix K = stiffness(distorted(type), {1, nu, 1});
    ASSERT_TRUE(K.allFinite());
    const Vector lambda = symmetric_eigenvalues(K);
    EXPECT_GE(lambda(0), -1e-13 * lambda.maxCoeff());
    EXPECT_GE(lambda(6), 1e-8 * lambda.maxCoeff());
  }
}

TEST_P(Element, NeedlesAndSheetsKeepTheirRigidMotions) {
  for (const Vector3& stretch : {Vector3(1, 1, 1e-4), Vector3(1, 1e-4, 1e-4), Vector3(1e4, 1, 1)}) {
    const Points X = distorted(type) * stretch.asDiagonal();
    ASSERT_GT(element_quality(type, X), 0.1);
    const Matrix K = stiffness(X);
    ASSERT_TRUE(K.allFinite());
    const Matrix R = rigid_modes(X, X.colwise().mean().transpose());
    EXPECT_LE((K * R).cwiseAbs().maxCoeff(),
              1e-12 * K.cwiseAbs().maxCoeff() * R.cwiseAbs().maxCoeff());
    EXPECT_GT(element_lumped_mass(type, X, 1).minCoeff(), 0);
  }
}

TEST_P(Element, StrainEnergyOfALinearFieldIsExact) {
  // Whatever the nodes' places: u = H x gives the energy V e : D : e / 2.
  Matrix3 H;
  H << 0.3, -0.2, 0.5, 0.1, 0.7, -0.4, 0.2, 0.6, -0.1;
  const Points X = distorted(type);
  const Points u = X * H.transpose();
  const Eigen::Map<const Vector> q(u.data(), u.size());
  const double lambda = 210e9 * 0.3 / (1.3 * 0.4), mu = 210e9 / 2.6;
  const Matrix3 strain = 0.5 * (H + H.transpose());
  const double density = 0.5 * lambda * strain.trace() * strain.trace() + mu * strain.squaredNorm();
  const double volume = element_mass(type, X, 1).sum();
  EXPECT_NEAR(0.5 * q.dot(stiffness(X) * q), density * volume, 1e-13 * density * volume);
}

TEST_P(Element, StressOfALinearFieldIsExact) {
  Matrix3 H;
  H << 3e-4, -2e-4, 5e-4, 1e-4, 7e-4, -4e-4, 2e-4, 6e-4, -1e-4;
  const Points X = distorted(type);
  const Points u = (X * H.transpose()).rowwise() + Vector3(1, 2, 3).transpose();
  const auto found = element_stress(type, hex, X, steel, u);
  const double lambda = 210e9 * 0.3 / (1.3 * 0.4), mu = 210e9 / 2.6;
  const Matrix3 stress = lambda * H.trace() * Matrix3::Identity() + mu * (H + H.transpose());
  Eigen::Matrix<double, 6, 1> exact;
  exact << stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(1, 2), stress(0, 2);
  // The rigid shift of 1 to 3 against strains of 1e-4 takes four digits.
  EXPECT_LE((found - exact).norm(), 1e-11 * exact.norm());
}

TEST_P(Element, TurnsWithItsNodes) {
  const Points X = distorted(type);
  const Matrix3 R = some_rotation();
  const Matrix K = stiffness(X), turned = stiffness(X * R.transpose());
  Matrix expected(K.rows(), K.cols());
  for (Index i = 0; i < X.rows(); ++i)
    for (Index j = 0; j < X.rows(); ++j)
      expected.block<3, 3>(3 * i, 3 * j) = R * K.block<3, 3>(3 * i, 3 * j) * R.transpose();
  EXPECT_LE((turned - expected).cwiseAbs().maxCoeff(), 1e-13 * K.cwiseAbs().maxCoeff());
  EXPECT_LE(
      (element_mass(type, X * R.transpose(), 1) - element_mass(type, X, 1)).cwiseAbs().maxCoeff(),
      1e-14);
}

TEST_P(Element, FollowsTheUnitsAndThePlace) {
  const Points X = distorted(type);
  const Matrix K = stiffness(X);
  // Millimetres and tonnes: K in N/mm
  const Matrix scaled = stiffness(1000 * X, {210e3, 0.3, 7.85e-9});
  EXPECT_LE((1000 * scaled - K).cwiseAbs().maxCoeff(), 1e-13 * K.cwiseAbs().maxCoeff());
  const Points far = X.rowwise() + Vector3(1e3, -2e3, 3e3).transpose();
  // The shifted coordinates themselves are rounded to 1e3 times the machine's precision.
  EXPECT_LE((stiffness(far) - K).cwiseAbs().maxCoeff(), 1e-11 * K.cwiseAbs().maxCoeff());
}

TEST_P(Element, MirroredElementHasTheMirroredStiffness) {
  const Points X = distorted(type);
  const auto& order = mirrored_order(type);
  Points Y(X.rows(), 3);
  for (Index i = 0; i < X.rows(); ++i) {
    Y.row(i) = X.row(order[i]);
    Y(i, 0) *= -1;
  }
  EXPECT_GT(element_quality(type, Y), 0);
  const Matrix K = stiffness(X), mirrored = stiffness(Y);
  const Vector3 sign(-1, 1, 1);
  double worst = 0;
  for (Index i = 0; i < X.rows(); ++i)
    for (Index j = 0; j < X.rows(); ++j) {
      const Index p = order[i], q = order[j];
      const Matrix3 expected = sign.asDiagonal() * K.block<3, 3>(3 * p, 3 * q) * sign.asDiagonal();
      worst =
          std::max(worst, (mirrored.block<3, 3>(3 * i, 3 * j) - expected).cwiseAbs().maxCoeff());
    }
  EXPECT_LE(worst, 1e-13 * K.cwiseAbs().maxCoeff());
}

class Mass : public testing::TestWithParam<ElementType> {};

TEST_P(Mass, TotalAndFirstMomentsAreExact) {
  const ElementType type = GetParam();
  const Points X = distorted(type);
  const double rho = 7850;
  const Matrix M = element_mass(type, X, rho);
  EXPECT_EQ(M, Matrix(M.transpose()));
  EXPECT_GT(symmetric_eigenvalues(M)(0), 0);
  const Vector m = element_lumped_mass(type, X, rho);
  EXPECT_GT(m.minCoeff(), 0);
  EXPECT_NEAR(m.sum(), M.sum(), 1e-14 * M.sum());
  if (n_nodes(type) > 8) return;
  // Lumping linear elements by row sums keeps the centre of mass.
  const Vector ones = Vector::Ones(X.rows());
  EXPECT_LE((X.transpose() * (M * ones - m)).norm(), 1e-13 * M.sum() * X.norm());
}

TEST_P(Mass, VolumeIsThatInsideTheFaces) {
  // Divergence theorem, V = 1/3 sum over faces of the integral of x . n, on straight-sided elements
  // with bilinear faces.
  const ElementType type = GetParam();
  const Points X = element_points(type, skew_corners(type));
  double volume = 0;
  const double g = 1 / std::sqrt(3.0);
  for (int side = 1; side <= n_sides(type); ++side) {
    auto nodes = side_nodes(type, side);
    nodes.resize(n_corners(side_kind(type, side)));
    const auto x = [&](std::size_t i) -> Vector3 { return X.row(nodes[i]).transpose(); };
    if (nodes.size() == 3) {
      volume += x(0).dot((x(1) - x(0)).cross(x(2) - x(0))) / 6;
      continue;
    }
    for (const double r : {-g, g})
      for (const double s : {-g, g}) {
        const Vector3 p = ((1 - r) * (1 - s) * x(0) + (1 + r) * (1 - s) * x(1) +
                           (1 + r) * (1 + s) * x(2) + (1 - r) * (1 + s) * x(3)) /
                          4;
        const Vector3 p_r = ((1 - s) * (x(1) - x(0)) + (1 + s) * (x(2) - x(3))) / 4;
        const Vector3 p_s = ((1 - r) * (x(3) - x(0)) + (1 + r) * (x(2) - x(1))) / 4;
        volume += p.dot(p_r.cross(p_s)) / 3;
      }
  }
  EXPECT_NEAR(element_mass(type, X, 1).sum(), volume, 1e-14 * volume);
}

TEST_P(Mass, RigidBodyOfAParallelepipedIsExact) {
  const ElementType type = GetParam();
  const Vector3 L(2, 0.5, 1.5);
  const double rho = 3;
  const Mesh mesh = box_mesh(type, {2, 1, 2}, L);
  for (const MassKind kind : {MassKind::consistent, MassKind::lumped}) {
    const auto model = assemble(mesh, {{{1, 0.3, rho}, HexFormulation::full}}, kind);
    const RigidBody body = rigid_body(model.M, mesh.coordinates);
    EXPECT_NEAR(body.mass, rho * L.prod(), 1e-14 * body.mass);
    if (kind == MassKind::lumped) continue;
    EXPECT_LE((body.center - L / 2).norm(), 1e-14 * L.norm());
    const Vector3 squares = L.cwiseAbs2();
    const Vector3 inertia =
        body.mass / 12 *
        Vector3(squares(1) + squares(2), squares(0) + squares(2), squares(0) + squares(1));
    EXPECT_LE((body.inertia - Matrix3(inertia.asDiagonal())).norm(), 1e-13 * inertia.norm());
  }
}

TEST_P(Mass, QualityTellsInvertedFromSound) {
  const ElementType type = GetParam();
  const Points X = affine(type);
  EXPECT_NEAR(element_quality(type, X), 1, 1e-12);
  EXPECT_NEAR(element_quality(type, 1e-200 * X), 1, 1e-12);
  EXPECT_NEAR(element_quality(type, 1e200 * X), 1, 1e-12);
  EXPECT_GT(element_quality(type, distorted(type)), 0.1);
  EXPECT_LT(element_quality(type, Points(-X)), 0);
  Points flat = X;
  flat.col(2) = flat.col(0) + 2 * flat.col(1);
  EXPECT_LE(element_quality(type, flat), 0);
  EXPECT_LE(element_quality(type, Points::Constant(X.rows(), 3, 0.7)), 0);
  Points thin = X;
  thin.col(2) *= 1e-4;
  EXPECT_NEAR(element_quality(type, thin), 1, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(All, Element, testing::ValuesIn(element_kinds()));
INSTANTIATE_TEST_SUITE_P(All, Mass, testing::ValuesIn(volume_types));

// C3D20R has six motions without strain at its points beside the rigid ones, C3D15 none.
TEST(ReducedIntegration, StrainsLinearFieldsExactlyInStraightElements) {
  Matrix3 H;
  H << 0.3, -0.2, 0.5, 0.1, 0.7, -0.4, 0.2, 0.6, -0.1;
  for (const auto& [type, n_zero] :
       {std::pair{ElementType::hex20, 12}, {ElementType::wedge15, 6}}) {
    const Points X = element_points(type, skew_corners(type)), u = X * H.transpose();
    const Matrix K = element_stiffness(type, HexFormulation::reduced, X, steel),
                 full = element_stiffness(type, HexFormulation::full, X, steel);
    const Eigen::Map<const Vector> q(u.data(), u.size());
    EXPECT_LE((K * q - full * q).norm(), 1e-13 * (full * q).norm());
    EXPECT_GT((K - full).norm(), 0.01 * full.norm());
    const Vector lambda = symmetric_eigenvalues(K);
    EXPECT_LE(lambda.head(n_zero).cwiseAbs().maxCoeff(), 1e-13 * lambda.maxCoeff());
    EXPECT_GE(lambda(n_zero), 1e-4 * lambda.maxCoeff());
    EXPECT_NEAR(element_mass(type, X, 1, HexFormulation::reduced).sum(),
                element_mass(type, X, 1).sum(), 1e-14 * X.norm());
  }
}

// Pure bending of a square brick, u = (x y, -x^2/2 - nu (y^2 - z^2)/2, -nu y z), E = 1.
double energy_of_bending(HexFormulation formulation, double nu) {
  const Points X = box_mesh(ElementType::hex8, {1, 1, 1}, Vector3(2, 2, 2)).coordinates.rowwise() -
                   Vector3(1, 1, 1).transpose();
  Points corners(8, 3);
  corners << -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1;
  EXPECT_EQ(X, corners);
  Vector u(24);
  for (Index i = 0; i < 8; ++i) {
    const double x = X(i, 0), y = X(i, 1), z = X(i, 2);
    u.segment<3>(3 * i) << x * y, -x * x / 2 - nu * (y * y - z * z) / 2, -nu * y * z;
  }
  return 0.5 * u.dot(element_stiffness(ElementType::hex8, formulation, X, {1, nu, 1}) * u);
}

constexpr double exact_bending = 0.5 * (2 * 8.0 / 12) * 2;  // E I kappa^2 L / 2

TEST(HexFormulation, IncompatibleModesBendWithoutLocking) {
  EXPECT_NEAR(energy_of_bending(HexFormulation::incompatible, 0.3), exact_bending, 1e-13);
  EXPECT_GT(energy_of_bending(HexFormulation::full, 0.3), 1.3 * exact_bending);
}

// All of it is that of two hourglass modes, of 1 and nu: a share of E (1 + nu^2) at any ratio,
// below the exact one. The modulus of pressure waves gave 170 times the exact one at the last
// ratio.
TEST(HexFormulation, HourglassStiffnessDoesNotGrowNearIncompressibility) {
  const double at_zero = energy_of_bending(HexFormulation::hourglass, 0);
  EXPECT_GT(at_zero, 0.4 * exact_bending);
  for (const double nu : {-0.5, 0.3, 0.49, 0.499, 0.4999}) {
    const double energy = energy_of_bending(HexFormulation::hourglass, nu);
    EXPECT_NEAR(energy, at_zero * (1 + nu * nu), 1e-10 * at_zero) << nu;
    EXPECT_LT(energy, exact_bending) << nu;
  }
}

}  // namespace
}  // namespace cbr::test::element_test
