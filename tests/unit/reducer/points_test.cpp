// SPDX-License-Identifier: GPL-3.0-or-later
// Points as nodes of the superelement, each of which moves a set of the mesh as a rigid body.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/superelement/superelement_check.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/partition/rigid_points.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::points_test {
namespace {

Component with_points(const std::map<std::string, std::string>& set_of_point, Index modes,
                      std::vector<std::string> sets = {}) {
  Component component;
  component.name = "beam";
  component.reduction.emplace();
  component.reduction->modes = modes;
  component.reduction->interface_sets = std::move(sets);
  for (const auto& [name, set] : set_of_point) {
    component.points[name].nodes = set;
    component.points[name].rigid = true;
    component.reduction->interface_points.push_back(name);
  }
  return component;
}

Superelement reduced(const Mesh& mesh, const Component& component, MassKind mass,
                     ReduceSettings settings = {}) {
  settings.points = rigid_points(mesh, component);
  return test::reduced(mesh, *component.reduction, mass, settings);
}

Mesh skewed() { return box_mesh({{5, 3, 2}, {5, 3, 2}, {1, 2, 3}, 0.08}); }

// u_c of the sets' nodes from the points' six dofs each   (c x 6 n_points)
Matrix rigid_map(const Superelement& of_sets, const Mesh& mesh, const Superelement& of_points,
                 const std::vector<std::string>& sets) {
  Matrix T = Matrix::Zero(of_sets.c(), of_points.c());
  for (std::size_t j = 0; j < sets.size(); ++j) {
    for (const Index node : set_nodes(mesh, sets[j])) {
      const Vector3 r = Vector3(mesh.coordinates.row(node)) -
                        Vector3(of_points.coordinates.row(static_cast<Index>(j)));
      for (Index i = 0; i < of_sets.c(); ++i) {
        const auto dof = static_cast<std::size_t>(i);
        if (of_sets.node_ids[of_sets.dof_node[dof]] != mesh.node_ids[node]) continue;
        const int d = of_sets.dof_component[dof];
        const Index column = 6 * static_cast<Index>(j);
        T(i, column + d) = 1;
        for (int a = 0; a < 3; ++a) T(i, column + 3 + a) = Vector3::Unit(a).cross(r)(d);
      }
    }
  }
  return T;
}

class PointsOfBothMasses : public testing::TestWithParam<MassKind> {};
INSTANTIATE_TEST_SUITE_P(Points, PointsOfBothMasses,
                         testing::Values(MassKind::lumped, MassKind::consistent));

// The modes are the same, and statics of the sets' nodes contain those of a rigid set.
TEST_P(PointsOfBothMasses, MatricesAreThoseOfTheSetsMovedRigidly) {
  const Mesh mesh = skewed();
  const Component component = with_points({{"left", "x_min"}, {"right", "x_max"}}, 12);
  const Superelement s = reduced(mesh, component, GetParam());
  const Superelement whole = reduced(mesh, with_points({}, 12, {"x_min", "x_max"}), GetParam());
  ASSERT_EQ(s.c(), 12);
  ASSERT_EQ(s.node_ids.size(), 2u);
  EXPECT_GT(s.node_ids[0], mesh.node_ids.back());
  EXPECT_EQ(s.nodesets.at("left"), std::vector<Index>{0});
  EXPECT_EQ(s.nodesets.at("right"), std::vector<Index>{1});
  EXPECT_EQ(s.dof_component, (std::vector<int>{0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5}));
  EXPECT_LT(relative(s.eigenvalues, whole.eigenvalues), 1e-10);
  const Matrix T = rigid_map(whole, mesh, s, {"x_min", "x_max"});
  EXPECT_LT(relative(s.K_cc, T.transpose() * whole.K_cc * T), 1e-11);
  EXPECT_LT(relative(s.M_cc, T.transpose() * whole.M_cc * T), 1e-11);
  const Matrix coupled = whole.M_kc * T;
  for (Index j = 0; j < s.k(); ++j) {
    const double sign = s.M_kc.row(j).dot(coupled.row(j)) < 0 ? -1 : 1;
    EXPECT_LT(relative(sign * s.M_kc.row(j), coupled.row(j)), 1e-6) << j;
  }
}

TEST_P(PointsOfBothMasses, RigidMotionsAreExact) {
  const Mesh mesh = skewed();
  Component component = with_points({{"left", "x_min"}, {"right", "x_max"}}, 4);
  component.points["left"].at = Vector3(-3, 1, 2);  // off its set
  const Superelement s = reduced(mesh, component, GetParam());
  EXPECT_EQ(Vector3(s.coordinates.row(0)), Vector3(-3, 1, 2));
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  const Matrix K = reduced_stiffness(s), M = reduced_mass(s);
  EXPECT_LT((K * R).cwiseAbs().maxCoeff(), 1e-11 * K.cwiseAbs().maxCoeff());
  Matrix mass = Matrix::Zero(6, 6);
  mass.diagonal().head(3).setConstant(s.rigid_body.mass);
  mass.bottomRightCorner(3, 3) = s.rigid_body.inertia;
  EXPECT_LT(relative(R.transpose() * M * R, mass), 1e-11);
  EXPECT_EQ((s.omega.array() == 0).count(), 6);
  check_rigid_motions(s, "here");
}

TEST_P(PointsOfBothMasses, FacesAndPointsStandTogether) {
  const Mesh mesh = skewed();
  const Superelement s = reduced(mesh, with_points({{"left", "x_min"}}, 12, {"x_max"}), GetParam());
  const Superelement whole = reduced(mesh, with_points({}, 12, {"x_min", "x_max"}), GetParam());
  const auto n_face = static_cast<Index>(set_nodes(mesh, "x_max").size());
  ASSERT_EQ(s.c(), 3 * n_face + 6);
  ASSERT_EQ(s.surfaces.size(), 1u);
  EXPECT_EQ(s.surfaces[0].name, "x_max");
  EXPECT_EQ(s.nodesets.at("left"), std::vector<Index>{n_face});
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  EXPECT_LT((reduced_stiffness(s) * R).cwiseAbs().maxCoeff(), 1e-11 * s.K_cc.cwiseAbs().maxCoeff());
  // Frequencies rise as the other face becomes rigid
  EXPECT_GT(s.omega(6), whole.omega(6));
}

// The usual base of a spacecraft: no stiffness, the mass of the whole, and its held modes.
TEST_P(PointsOfBothMasses, OnePointAloneHasNoStiffness) {
  const Mesh mesh = skewed();
  const Superelement s = reduced(mesh, with_points({{"base", "x_min"}}, 10), GetParam());
  const Superelement whole = reduced(mesh, with_points({}, 10, {"x_min"}), GetParam());
  ASSERT_EQ(s.c(), 6);
  EXPECT_TRUE(s.K_cc.isZero(0));
  EXPECT_LT(relative(s.eigenvalues, whole.eigenvalues), 1e-10);
  const Matrix T = rigid_map(whole, mesh, s, {"x_min"});
  EXPECT_LT(relative(s.M_cc, T.transpose() * whole.M_cc * T), 1e-11);
  EXPECT_EQ((s.omega.array() == 0).count(), 6);
  check(s, "here");
}

// In panels and front by front: the same.
TEST(Points, EveryWayOfCondensationGivesTheSame) {
  const Mesh mesh = skewed();
  const Component component = with_points({{"left", "x_min"}, {"right", "x_max"}}, 6);
  const Superelement first = reduced(mesh, component, MassKind::lumped);
  for (const CondensationWay way :
       {CondensationWay::product, CondensationWay::second_solve, CondensationWay::fronts}) {
    ReduceSettings settings;
    settings.way = way;
    const Superelement s = reduced(mesh, component, MassKind::lumped, settings);
    EXPECT_LT(relative(s.K_cc, first.K_cc), 1e-11);
    EXPECT_LT(relative(s.M_cc, first.M_cc), 1e-11);
  }
}

// Axes x along the beam: EA, GJ, and Timoshenko's bending with shear (Przemieniecki 1968, 5.6).
Matrix beam_stiffness(double E, double G, double L, double b) {
  const double A = b * b, I = A * A / 12, J = 0.1406 * A * A, kappa = 5.0 / 6,
               phi = 12 * E * I / (kappa * G * A * L * L), k = E * I / (1 + phi) / (L * L * L);
  Matrix K = Matrix::Zero(12, 12);
  const auto bar = [&](Index i, double stiffness) {
    K(i, i) = K(i + 6, i + 6) = stiffness;
    K(i, i + 6) = K(i + 6, i) = -stiffness;
  };
  bar(0, E * A / L);
  bar(3, G * J / L);
  // along y with rotation about z, and along z with rotation about y, of the other sign
  for (const double s : {1.0, -1.0}) {
    const Index u = s > 0 ? 1 : 2, t = s > 0 ? 5 : 4;
    const Eigen::Matrix4d block{
        {12 * k, 6 * k * L * s, -12 * k, 6 * k * L * s},
        {6 * k * L * s, (4 + phi) * k * L * L, -6 * k * L * s, (2 - phi) * k * L * L},
        {-12 * k, -6 * k * L * s, 12 * k, -6 * k * L * s},
        {6 * k * L * s, (2 - phi) * k * L * L, -6 * k * L * s, (4 + phi) * k * L * L}};
    const std::vector<Index> dofs = {u, t, u + 6, t + 6};
    K(dofs, dofs) += block;
  }
  return K;
}

TEST(Points, ABeamHasTimoshenkosTwelveByTwelve) {
  const double E = 1000, L = 20, b = 1;
  const Mesh mesh = box_mesh({{40, 6, 6}, {L, b, b}, {0, -0.5, -0.5}});
  const Component beam = with_points({{"left", "x_min"}, {"right", "x_max"}}, 0);
  Report report("test", Verbosity::quiet);
  const Superelement s = reduce(mesh, properties(mesh, {E, 0, 2}), MassKind::lumped,
                                *beam.reduction, {.points = rigid_points(mesh, beam)}, report);
  const Matrix K = beam_stiffness(E, E / 2, L, b);
  // Against sqrt(K_ii K_jj): rotations and translations have their own units
  const Vector scale = K.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix error = scale.asDiagonal() * (s.K_cc - K) * scale.asDiagonal();
  EXPECT_LT(std::abs(error(0, 0)), 1e-10);  // tension alone, without Poisson's ratio
  // Rigid ends hinder the warping of torsion
  const std::vector<Index> torsion = {3, 9}, others = {0, 1, 2, 4, 5, 6, 7, 8, 10, 11};
  EXPECT_LT(error(others, others).cwiseAbs().maxCoeff(), 2e-3);
  EXPECT_LT(error(torsion, torsion).cwiseAbs().maxCoeff(), 0.03);
}

TEST(Points, RecoveryMovesTheSetsRigidly) {
  const Mesh mesh = skewed();
  Component component = with_points({{"left", "x_min"}, {"right", "x_max"}}, 5);
  component.reduction->recovery = true;
  const Superelement s = reduced(mesh, component, MassKind::lumped);
  ASSERT_EQ(s.recovery.size(), 1u);
  const Superelement::Recovery& recovery = s.recovery.front();
  // Every node of the mesh is there once
  EXPECT_EQ(recovery.node_ids.size(), mesh.node_ids.size());
  std::map<Index, Index> row;
  for (const Index id : recovery.node_ids) row.emplace(id, static_cast<Index>(row.size()));
  Vector u_c(12);
  for (Index i = 0; i < 12; ++i) u_c(i) = std::cos(1.0 + static_cast<double>(i));
  const Vector u = recovery.Psi * u_c + recovery.Phi * Vector::Constant(s.k(), 0.3);
  for (Index j = 0; j < 2; ++j) {
    const Vector3 U = u_c.segment<3>(6 * j), theta = u_c.segment<3>(6 * j + 3);
    for (const Index node : set_nodes(mesh, j == 0 ? "x_min" : "x_max")) {
      const Vector3 x = mesh.coordinates.row(node);
      const Index i = row.at(mesh.node_ids[node]);
      EXPECT_EQ(Vector3(recovery.coordinates.row(i)), x);
      EXPECT_LT((u.segment<3>(3 * i) - U - theta.cross(x - Vector3(s.coordinates.row(j)))).norm(),
                1e-13);
    }
  }
  // Elements name nodes by their place behind the two points
  for (const Block& block : recovery.blocks)
    for (Index e = 0; e < block.connectivity.rows(); ++e)
      for (Index a = 0; a < block.connectivity.cols(); ++a)
        EXPECT_EQ(recovery.node_ids[block.connectivity(e, a) - 2],
                  mesh.node_ids[mesh.blocks[0].connectivity(e, a)]);
  // A rigid motion of the points is one of the whole
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c());
  EXPECT_LT(relative(recovery.Psi * R, rigid_modes(recovery.coordinates, s.rigid_body.center)),
            1e-11);
}

TEST(Points, TheFileKeepsSixDofs) {
  const TemporaryFolder folder;
  const Mesh mesh = skewed();
  Component component = with_points({{"left", "x_min"}, {"right", "x_max"}}, 5);
  component.reduction->recovery = true;
  Superelement s = reduced(mesh, component, MassKind::lumped);
  s.content_hash = "none";
  write_superelement(s, folder / "beam.cbr.h5");
  const Superelement back = read_superelement(folder / "beam.cbr.h5");
  EXPECT_EQ(back.dof_component, s.dof_component);
  EXPECT_EQ(back.dof_node, s.dof_node);
  EXPECT_EQ(back.nodesets, s.nodesets);
  EXPECT_EQ(back.K_cc, s.K_cc);
}

TEST(Points, RefusesANodeWithSomeOfSixDofs) {
  Superelement s =
      reduced(skewed(), with_points({{"left", "x_min"}}, 5, {"x_max"}), MassKind::lumped);
  s.content_hash = "none";
  check(s, "here");
  s.dof_component[0] = 3;
  EXPECT_SAYS(refusal_of([&] { check(s, "here"); }), "lacks component 0");
  s.dof_component[0] = 6;
  EXPECT_SAYS(refusal_of([&] { check(s, "here"); }), "6 is none of");
}

TEST(Points, RefusesWhatHasNoRotationOrTwoOwners) {
  const Mesh mesh = box_mesh({{5, 3, 2}, {5, 3, 2}});
  const auto message = [&](const Component& component) {
    return refusal_of([&] { rigid_points(mesh, component); });
  };
  EXPECT_SAYS(message(with_points({{"left", "edge"}}, 5)), "on a line");
  EXPECT_SAYS(message(with_points({{"left", "corner"}}, 5)), "are one");
  EXPECT_SAYS(message(with_points({{"left", "x_min"}, {"low", "z_min"}}, 5)),
              "is of the point 'left' too");
  EXPECT_SAYS(message(with_points({{"left", "x_min"}}, 5, {"z_min"})), "reduction.interface too");
  EXPECT_SAYS(message(with_points({{"x_max", "x_min"}}, 5)), "another one");
  EXPECT_SAYS(message(with_points({{"left", "nothing"}}, 5)), "nothing");
}

}  // namespace
}  // namespace cbr::test::points_test
