// SPDX-License-Identifier: GPL-3.0-or-later
// Loads inside the part, against the full model: with residual vectors and without.
#include "reducer/modes/interior_loads.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::interior_loads_test {
namespace {

// A load on two faces in the middle of the long side, far from the interface at x_max.
Mesh loaded() {
  Mesh mesh = box_mesh({{8, 3, 3}, {8, 3, 3}, {0, 0, 0}, 0.03});
  Sideset patch{"patch", 20, {}};
  for (const Side& side : mesh.sidesets.at(3).sides)  // y_max
    if (side.element % 8 == 3 && patch.sides.size() < 2) patch.sides.push_back(side);
  Sideset twin = patch;
  twin.name = "twin";
  twin.id = 21;
  mesh.sidesets.push_back(patch);
  mesh.sidesets.push_back(twin);
  return mesh;
}

Superelement reduced(const std::vector<std::string>& loads, Index modes = 8,
                     MassKind mass = MassKind::lumped) {
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = modes;
  options.loads = loads;
  options.recovery = true;
  return test::reduced(loaded(), options, mass);
}

struct Full {
  FiniteElementModel model;
  Partition p;
  InteriorLoads loads;
};
Full full(MassKind mass = MassKind::lumped) {
  const Mesh mesh = loaded();
  Full f;
  f.model = assemble(mesh, properties(mesh, soft), mass);
  f.p = partition(f.model, interface_nodes(mesh, f.model, {"x_max"}));
  f.loads = interior_loads(mesh, f.model, f.p, {"patch"});
  return f;
}

class InteriorLoad : public testing::TestWithParam<MassKind> {};
INSTANTIATE_TEST_SUITE_P(Masses, InteriorLoad,
                         testing::Values(MassKind::lumped, MassKind::consistent));

TEST_P(InteriorLoad, ResidualVectorsAreModalCoordinatesLikeOthers) {
  const Superelement s = reduced({"patch"}, 8, GetParam()), plain = reduced({}, 8, GetParam());
  const Full f = full(GetParam());
  EXPECT_EQ(s.n_residual, 3);
  EXPECT_EQ(s.k(), 11);
  EXPECT_TRUE(plain.loads.empty());
  EXPECT_EQ(Vector(s.eigenvalues.head(8)), plain.eigenvalues);
  const Matrix &Phi = s.recovery.at(0).Phi, &Psi = s.recovery.at(0).Psi;
  EXPECT_LT((Phi.transpose() * f.p.M_II * Phi - Matrix::Identity(11, 11)).cwiseAbs().maxCoeff(),
            1e-10);
  const Matrix K = Phi.transpose() * f.p.K_II * Phi;
  EXPECT_LT((K - Matrix(s.eigenvalues.asDiagonal())).cwiseAbs().maxCoeff(),
            1e-10 * K.cwiseAbs().maxCoeff());
  const Matrix M_kc = Phi.transpose() * (f.p.M_IC + f.p.M_II * Psi);
  EXPECT_LT((M_kc - s.M_kc).cwiseAbs().maxCoeff(), 1e-10 * M_kc.cwiseAbs().maxCoeff());
}

TEST_P(InteriorLoad, DisplacementUnderTheLoadIsRightWithThemAndWrongWithout) {
  const Superelement s = reduced({"patch"}, 8, GetParam());
  const Full f = full(GetParam());
  const SparseCholesky K_II(f.p.K_II);
  const Matrix u = K_II.solve(f.loads.F_I);  // the interface held
  const Matrix& force = s.loads.at("patch").force;
  EXPECT_NEAR(s.loads.at("patch").weight, f.loads.areas.at(0), 1e-12);
  for (int d = 0; d < 3; ++d) {
    const double right = f.loads.F_I.col(d).dot(u.col(d));
    const Vector part = force.col(d).head(11).cwiseAbs2().cwiseQuotient(s.eigenvalues);
    EXPECT_NEAR(part.sum(), right, 1e-10 * right) << d;
    EXPECT_LT(part.head(8).sum(), 0.97 * right) << d;  // modes alone
    // Of all of the interior, and what the interface feels
    const Vector q = force.col(d).head(11).cwiseQuotient(s.eigenvalues);
    EXPECT_LT((s.recovery.at(0).Phi * q - u.col(d)).norm(), 1e-10 * u.col(d).norm());
    const Vector reaction = f.loads.F_C.col(d) - f.p.K_IC.transpose() * u.col(d);
    EXPECT_LT((force.col(d).tail(s.c()) - reaction).norm(), 1e-10 * reaction.norm());
  }
}

// The load rises within a period of the first mode and stays, the interface held: the displacement
// under it, against all modes of the full model.
TEST_P(InteriorLoad, ARisingLoadIsFollowed) {
  const Superelement s = reduced({"patch"}, 8, GetParam());
  const Full f = full(GetParam());
  const Eigenpairs all = dense_eigenpairs(Matrix(f.p.K_II), Matrix(f.p.M_II), f.p.n_interior());
  const Vector a = (all.Phi.transpose() * f.loads.F_I.col(1)).cwiseAbs2(),
               b = s.loads.at("patch").force.col(1).head(11).cwiseAbs2();
  const double rise = 2 * std::numbers::pi / std::sqrt(all.lambda(0));
  double whole = 0, with = 0, without = 0;
  for (int i = 1; i <= 300; ++i) {
    const double t = 0.01 * rise * i, held = std::max(0.0, t - rise);
    // q'' + lambda q = min(t, rise) / rise
    const auto swing = [&](double lambda) {
      const double omega = std::sqrt(lambda);
      return ((t - held) - (std::sin(omega * t) - std::sin(omega * held)) / omega) /
             (rise * lambda);
    };
    const double right = a.dot(all.lambda.unaryExpr(swing));
    const Vector parts = b.cwiseProduct(s.eigenvalues.unaryExpr(swing));
    whole += right * right;
    with += std::pow(parts.sum() - right, 2);
    without += std::pow(parts.head(8).sum() - right, 2);
  }
  EXPECT_GT(std::sqrt(without / whole), 0.03);
  EXPECT_LT(std::sqrt(with / whole), 0.005);
}

TEST(InteriorLoads, TheSameFacesTwiceGiveNoVectorTwice) {
  const Superelement s = reduced({"patch", "twin"});
  EXPECT_EQ(s.n_residual, 3);
  EXPECT_EQ(s.loads.size(), 2U);
}

TEST(InteriorLoads, FacesOfTheInterfaceNeedNone) {
  const Superelement s = reduced({"x_max"});
  EXPECT_EQ(s.n_residual, 0);
  EXPECT_TRUE(s.loads.empty());
}

TEST(InteriorLoads, WhereTheModesHoldAllNothingIsLeft) {
  const Superelement s = reduced({"patch"}, full().p.n_interior());
  EXPECT_EQ(s.n_residual, 0);
  EXPECT_EQ(s.loads.size(), 1U);
}

TEST(InteriorLoads, AForceMovesTheFreeComponentAsARigidBody) {
  const Superelement s = reduced({"patch"});
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  const auto& load = s.loads.at("patch");
  const Matrix total = R.leftCols(3).transpose() * load.force;
  EXPECT_LT((total - load.weight * Matrix3::Identity()).cwiseAbs().maxCoeff(), 1e-10 * load.weight);
}

TEST(InteriorLoads, AnUnknownSetIsNamed) {
  EXPECT_SAYS(test::refusal_of([&] { reduced({"patsch"}); }), "no sideset 'patsch'");
}

}  // namespace
}  // namespace cbr::test::interior_loads_test
