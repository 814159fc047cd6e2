// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/characteristic/characteristic.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "common/base/error.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/mesh/face_weights.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::characteristic_test {
namespace {

ReductionOptions characteristic(std::vector<std::string> sets, Index fixed,
                                CharacteristicOptions of) {
  ReductionOptions options;
  options.basis = Basis::characteristic;
  options.interface_sets = std::move(sets);
  options.modes = fixed;
  options.characteristic = std::move(of);
  return options;
}

Superelement craig_bampton(const Mesh& mesh, const std::vector<std::string>& sets, Index fixed) {
  ReductionOptions options;
  options.interface_sets = sets;
  options.modes = fixed;
  return reduced(mesh, options);
}

// Elastic compliance of the interface, n x n of its dofs: of the diagonal form's rows, without
// rigid motions.
Matrix compliance(const Matrix& V, const Vector& lambda) {
  const Index r = (lambda.array() == 0).count(), e = lambda.size() - r;
  return V.rightCols(e) * lambda.tail(e).cwiseInverse().asDiagonal() * V.rightCols(e).transpose();
}
Matrix compliance(const Superelement& s) {
  if (s.is_characteristic()) return compliance(s.characteristic.V, s.eigenvalues);
  return compliance(s.V.bottomRows(s.c()), s.omega.cwiseAbs2());
}

const Surface& surface_of(const Superelement& s, const std::string& name) {
  return *std::find_if(s.surfaces.begin(), s.surfaces.end(),
                       [&](const Surface& of) { return of.name == name; });
}

double relative(const Matrix& A, const Matrix& B) { return (A - B).norm() / B.norm(); }

TEST(Characteristic, IsARitzSpaceThatGrowsInto_Craig_Bamptons) {
  const Mesh mesh = skewed();
  const Superelement whole = craig_bampton(mesh, {"surface"}, 10);
  const Vector exact = whole.omega.cwiseAbs2();
  Vector before = Vector::Constant(16, HUGE_VAL);
  for (const Index modes : {Index{0}, Index{12}, Index{60}, whole.c() - 7}) {
    const Superelement s = reduced(mesh, characteristic({"surface"}, 10, {modes}));
    ASSERT_EQ(s.k(), 10 + 6 + modes);
    EXPECT_EQ((s.eigenvalues.array() == 0).count(), 6);
    // Never below, and lower with more modes: each eigenvalue by itself
    for (Index j = 6; j < 16; ++j) {
      EXPECT_GT(s.eigenvalues(j), exact(j) * (1 - 1e-10)) << modes << " " << j;
      EXPECT_LT(s.eigenvalues(j), before(j) * (1 + 1e-10)) << modes << " " << j;
    }
    before = s.eigenvalues.head(16);
  }
  EXPECT_LT((before - exact.head(16)).cwiseAbs().maxCoeff(), 1e-3 * exact(15));
}

TEST(Characteristic, RigidMotionsCarryAllMassWhateverIsKept) {
  const Mesh mesh = skewed();
  for (const CharacteristicOptions& of :
       {CharacteristicOptions{3}, CharacteristicOptions{3, {"x_max"}},
        CharacteristicOptions{0, {}, false, {"x_max"}}}) {
    for (const MassKind kind : {MassKind::lumped, MassKind::consistent}) {
      ReductionFigures figures;
      const Superelement s = reduced(mesh, characteristic({"surface"}, 8, of), kind, &figures);
      const Matrix R = reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c());
      const Matrix V_r = s.characteristic.V.leftCols(6), E = PivotedQr(V_r).solve(R),
                   mass = E.transpose() * E;
      EXPECT_LT((V_r * E - R).norm(), 1e-11 * R.norm());
      EXPECT_LT(relative(mass.topLeftCorner(3, 3), s.rigid_body.mass * Matrix3::Identity()), 1e-10);
      EXPECT_LT(relative(mass.bottomRightCorner(3, 3), s.rigid_body.inertia), 1e-10);
      EXPECT_GT(figures.characteristic.rho.minCoeff(), 0.01);
    }
  }
}

TEST(Characteristic, StaticsOfKeptNodesAreExact) {
  const Mesh mesh = skewed();
  const Matrix exact = compliance(craig_bampton(mesh, {"surface"}, 0));
  ReductionFigures figures;
  const Superelement s = reduced(mesh, characteristic({"surface"}, 0, {2, {"x_max", "corner"}}),
                                 MassKind::lumped, &figures);
  std::vector<Index> kept;
  const auto nodes = surface_nodes(surface_of(s, "x_max"));
  for (Index i = 0; i < s.c(); ++i)
    if (std::binary_search(nodes.begin(), nodes.end(), s.dof_node[i])) kept.push_back(i);
  EXPECT_EQ(figures.characteristic.n_kept, 3 * (20 + 1));
  EXPECT_EQ(figures.characteristic.n_rigid, 0);
  // Forces in equilibrium on the kept dofs, as the inertia that balances others is on all nodes:
  // K_cc C K_cc-like projection
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c())(kept, Eigen::all);
  const Matrix Q = orthonormal_basis(R);
  const Matrix P = Matrix::Identity(R.rows(), R.rows()) - Q * Q.transpose();
  const Matrix found = compliance(s)(kept, kept);
  EXPECT_LT(relative(P * found * P, P * exact(kept, kept) * P), 1e-9);
}

// The shapes have the compliance under a uniform pressure, with shear under any uniform traction;
// not that of single nodes.
TEST(Characteristic, ResponsesToUniformPressureHaveItsCompliance) {
  const Mesh mesh = skewed();
  // Without fixed-interface modes: inertia that balances a load moves them a little too
  const Superelement whole = craig_bampton(mesh, {"surface"}, 0);
  const Matrix exact = compliance(whole);
  for (const bool shear : {false, true}) {
    const Matrix P = uniform_loads(whole, surface_of(whole, "x_max"), shear);
    const Matrix B = P.col(0).asDiagonal();  // dof by dof
    const Index step = P.cols();
    ReductionFigures figures;
    const Superelement s = reduced(mesh, characteristic({"surface"}, 0, {4, {}, shear, {"x_max"}}),
                                   MassKind::lumped, &figures);
    EXPECT_EQ(figures.characteristic.n_uniform, step);
    EXPECT_EQ(s.k(), 6 + 4 + step);
    const Matrix found = compliance(s);
    EXPECT_LT(relative(P.transpose() * found * P, P.transpose() * exact * P), 1e-8);
    EXPECT_GT(relative(B.transpose() * found * B, B.transpose() * exact * B), 0.01);
  }
}

TEST(Characteristic, PressureActsInwardsOnTheWholeArea) {
  const Superelement s = craig_bampton(skewed(), {"surface"}, 0);
  const Matrix B = uniform_loads(s, surface_of(s, "surface"), false);
  const double area = face_weights(surface_of(s, "surface"), s.coordinates).sum();
  Vector3 sum = Vector3::Zero();
  double outwards = 0;
  for (Index i = 0; i < s.c(); ++i) {
    const double f = B.row(i).sum();
    sum[s.dof_component[i]] += f;
    outwards += f * (s.coordinates(s.dof_node[i], s.dof_component[i]));
  }
  EXPECT_LT(sum.norm(), 1e-12 * area);  // of a closed surface
  EXPECT_LT(outwards, -3 * 0.9 * 60);   // - integral of x . n = -3 V
  EXPECT_GT(area, 2 * (20 + 15 + 12) * 0.95);
}

// Of serendipity faces: corners are pulled by a twelfth of each face.
TEST(Characteristic, ResponsesOfSecondOrderFacesAreOfTheirUniformPressure) {
  const Mesh mesh =
      test::box_with_faces(ElementType::hex20, {3, 3, 2}, {5, 4, 3}, "z_min", "z_max");
  const Superelement whole = craig_bampton(mesh, {"z_min", "z_max"}, 0);
  const Superelement s =
      reduced(mesh, characteristic({"z_min", "z_max"}, 0, {4, {}, false, {"z_max"}}));
  const Points normals = face_normals(surface_of(whole, "z_max"), whole.coordinates);
  Vector pressure(whole.c());
  for (Index i = 0; i < whole.c(); ++i)
    pressure[i] = -normals(whole.dof_node[i], whole.dof_component[i]);
  EXPECT_GT(pressure.maxCoeff(), 0);
  EXPECT_LT(pressure.minCoeff(), 0);
  EXPECT_NEAR(pressure.dot(compliance(s) * pressure), pressure.dot(compliance(whole) * pressure),
              1e-14 * pressure.dot(compliance(whole) * pressure));
}

TEST(Characteristic, RecoveryMovesTheInteriorAlong) {
  const Mesh mesh = skewed();
  ReductionOptions options = characteristic({"x_max"}, 6, {4, {}, false, {"x_max"}});
  options.recovery = true;
  const Superelement s = reduced(mesh, options);
  const auto& recovery = s.recovery.at(0);
  ASSERT_EQ(recovery.Phi.cols(), s.k());
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c());
  const Matrix q = PivotedQr(s.characteristic.V.leftCols(6)).solve(R);
  const Matrix u = recovery.Psi * R + recovery.Phi.leftCols(6) * q;
  for (Index i = 0; i < recovery.coordinates.rows(); ++i) {
    const Vector3 arm = recovery.coordinates.row(i).transpose() - s.rigid_body.center;
    EXPECT_LT((u.block(3 * i, 5, 3, 1) - Vector3::UnitZ().cross(arm)).norm(), 1e-9);
  }
}

std::string message_of(const Mesh& mesh, const ReductionOptions& options) {
  return refusal_of([&] { reduced(mesh, options); });
}

TEST(Characteristic, ByDefaultASmallInterfaceHasWhatShapesThereIsRoomFor) {
  const Mesh mesh = skewed();
  CharacteristicOptions options{40};
  const Index c = craig_bampton(mesh, {"x_max"}, 10).c();
  options.modes = c;  // more than there is room for
  EXPECT_THROW(reduced(mesh, characteristic({"x_max"}, 10, options)), InputError);
  options.is_default_modes = true;
  EXPECT_EQ(reduced(mesh, characteristic({"x_max"}, 10, options)).k(), 10 + c - 1);
}

TEST(Characteristic, RefusesByName) {
  const Mesh mesh = skewed({3, 2, 2});
  const auto message = [&](const CharacteristicOptions& of) {
    return message_of(mesh, characteristic({"x_max"}, 3, of));
  };
  EXPECT_SAYS(message({21}), "characteristic.modes: 27 requested, but only 27 dofs");
  EXPECT_EQ(message({20}), "no error");
  EXPECT_SAYS(message({3, {"x_mx"}}),
              "characteristic.keep: the interface keeps no set 'x_mx', did you mean 'x_max'");
  EXPECT_SAYS(message({3, {"x_max"}}), "nothing is left to reduce");
  EXPECT_EQ(message({3, {}, false, {"x_max"}}), "no error");
  EXPECT_SAYS(message_of(mesh, characteristic({"surface"}, 0, {3, {"corner"}})),
              "do not hold the others");
}

}  // namespace
}  // namespace cbr::test::characteristic_test
