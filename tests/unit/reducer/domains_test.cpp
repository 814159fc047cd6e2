// SPDX-License-Identifier: GPL-3.0-or-later
// All modes kept, a component in several domains is the component.
#include "reducer/domains/domains.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/LU>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/partition/partition.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/cut_meshes.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::domains_test {
namespace {

constexpr Index all_modes = 1000000;

ReductionOptions in_domains(Index domains, Index modes, std::vector<std::string> sets = {"x_min"}) {
  ReductionOptions options;
  options.interface_sets = std::move(sets);
  options.modes = modes;
  options.domains = domains;
  return options;
}

SuperelementGroup reduced(const Mesh& mesh, const ReductionOptions& options,
                          MassKind mass = MassKind::lumped, GroupFigures* figures = nullptr) {
  Report report("test", Verbosity::quiet);
  return reduce_domains(mesh, properties(mesh, soft), mass, options, {}, report, figures);
}

// Rows of the joined superelement that hold the dofs of these mesh nodes.
std::vector<Index> rows_of(const Superelement& whole, const Mesh& mesh,
                           const std::vector<Index>& nodes) {
  std::vector<Index> rows;
  for (const Index node : nodes) {
    const Index id = mesh.node_ids[node];
    const Index at =
        std::find(whole.node_ids.begin(), whole.node_ids.end(), id) - whole.node_ids.begin();
    for (Index i = 0; i < 3; ++i) rows.push_back(whole.k() + 3 * at + i);
  }
  return rows;
}

// (K - omega^2 M)^-1 on some dofs: all that a load on them can feel, static or moving.
Matrix compliance(const Matrix& K, const Matrix& M, double omega, const std::vector<Index>& dofs) {
  const Matrix inverse = Lu(K - omega * omega * M).inverse();
  return inverse(dofs, dofs);
}

struct Case {
  const char* name;
  Mesh mesh;
};

class WholeComponent : public testing::TestWithParam<MassKind> {
 protected:
  static std::vector<Case> cases() {
    return {{"warped hexes", box_mesh({{5, 4, 3}, {5, 4, 3}, {1, 2, 3}, 0.1})},
            {"tet10", tet10_mesh({2, 2, 1}, 0.03)},
            {"mixed", mixed_mesh({4, 3, 2}, 0.06)},
            {"comb", comb_mesh(4, 4)}};
  }
};
INSTANTIATE_TEST_SUITE_P(Domains, WholeComponent,
                         testing::Values(MassKind::lumped, MassKind::consistent),
                         [](const auto& mass) {
                           return mass.param == MassKind::lumped ? "lumped" : "consistent";
                         });

TEST_P(WholeComponent, LeavesTheMassOnItsInterfaceThatTheJoinedMassDoes) {
  for (const auto& [name, mesh] : cases()) {
    for (const Index modes : {Index{0}, Index{5}, all_modes}) {
      const SuperelementGroup group = reduced(mesh, in_domains(2, modes), GetParam());
      const Superelement whole = join(group);
      const std::vector<Index> dofs = rows_of(whole, mesh, set_nodes(mesh, "x_min"));
      const Matrix left = Lu(Matrix(Lu(reduced_mass(whole)).inverse()(dofs, dofs))).inverse();
      const std::optional<Vector3> rho =
          residual_mass_share(group, component_interface(mesh, {"x_min"}));
      ASSERT_TRUE(rho) << name;
      for (Index axis = 0; axis < 3; ++axis) {
        const auto r = Eigen::seq(axis, Eigen::last, 3);
        EXPECT_NEAR((*rho)(axis), left(r, r).sum() / group.rigid_body.mass, 1e-10) << name << modes;
      }
    }
    EXPECT_FALSE(residual_mass_share(reduced(mesh, in_domains(2, 0), GetParam()), {}, 2)) << name;
  }
}

TEST_P(WholeComponent, HasTheFullModelsFrequenciesAndCompliances) {
  for (const auto& [name, mesh] : cases()) {
    const FiniteElementModel model = assemble(mesh, properties(mesh, soft), GetParam());
    const Matrix K = model.K, M = model.M;
    const Vector full = dense_eigenpairs(K, M, K.rows()).lambda;
    const std::vector<Index> tip = set_nodes(mesh, "x_min");
    std::vector<Index> dofs;
    for (const Index node : tip) {
      for (Index i = 0; i < 3; ++i) dofs.push_back(3 * model.row[node] + i);
    }
    for (const Index n : {2, 3, 5, 8}) {
      const Superelement whole = join(reduced(mesh, in_domains(n, all_modes), GetParam()));
      ASSERT_EQ(whole.n(), K.rows()) << name << " " << n;
      const Matrix K_hat = reduced_stiffness(whole), M_hat = reduced_mass(whole);
      const Vector lambda = dense_eigenpairs(K_hat, M_hat, whole.n()).lambda;
      for (Index j = 6; j < lambda.size(); ++j)
        EXPECT_NEAR(lambda(j), full(j), 1e-9 * full(j)) << name << " " << n << " " << j;
      EXPECT_LT(lambda.head(6).cwiseAbs().maxCoeff(), 1e-12 * full(full.size() - 1));
      const std::vector<Index> rows = rows_of(whole, mesh, tip);
      // An imaginary frequency for the static end of it, and two between resonances.
      EXPECT_LT(relative(compliance(K_hat, -M_hat, std::sqrt(0.1 * full(6)), rows),
                         compliance(K, -M, std::sqrt(0.1 * full(6)), dofs)),
                1e-9);
      for (const Index j : {6, 20}) {
        const double omega = std::sqrt(0.5 * (full(j) + full(j + 1)));
        EXPECT_LT(relative(compliance(K_hat, M_hat, omega, rows), compliance(K, M, omega, dofs)),
                  1e-8)
            << name << " " << n;
      }
    }
  }
}

TEST_P(WholeComponent, MovesAsARigidBodyWithoutForceAndWithItsMass) {
  for (const auto& [name, mesh] : cases()) {
    Report report("test", Verbosity::quiet);
    const Superelement one =
        reduce(mesh, properties(mesh, soft), GetParam(), in_domains(1, 3), {}, report);
    for (const Index modes : {Index{0}, Index{4}, all_modes}) {
      const SuperelementGroup group = reduced(mesh, in_domains(4, modes), GetParam());
      const Superelement whole = join(group);
      const Matrix R = reduced_rigid_modes(whole, group.rigid_body.center);
      EXPECT_LT((reduced_stiffness(whole) * R).cwiseAbs().maxCoeff(),
                1e-11 * whole.K_cc.cwiseAbs().maxCoeff() * R.cwiseAbs().maxCoeff());
      const Matrix inertia = R.transpose() * reduced_mass(whole) * R;
      EXPECT_NEAR(group.rigid_body.mass, one.rigid_body.mass, 1e-12 * one.rigid_body.mass);
      EXPECT_LT((group.rigid_body.center - one.rigid_body.center).norm(),
                1e-12 * one.rigid_body.center.norm());
      EXPECT_LT(relative(group.rigid_body.inertia, one.rigid_body.inertia), 1e-11);
      EXPECT_LT(relative(inertia.topLeftCorner(3, 3), one.rigid_body.mass * Matrix3::Identity()),
                1e-11);
      EXPECT_LT(relative(inertia.bottomRightCorner(3, 3), one.rigid_body.inertia), 1e-10);
    }
  }
}

TEST(Domains, DiagonalFormIsThatOfTheWhole) {
  const Mesh mesh = box_mesh({{5, 4, 3}, {5, 4, 3}, {1, 2, 3}, 0.1});
  const SuperelementGroup group = reduced(mesh, in_domains(3, 10));
  ASSERT_TRUE(group.has_diagonal_form());
  const Matrix M = reduced_mass(join(group)), K = reduced_stiffness(join(group));
  EXPECT_LT((group.V.transpose() * M * group.V - Matrix::Identity(M.rows(), M.cols()))
                .cwiseAbs()
                .maxCoeff(),
            1e-11);
  const Vector lambda = group.omega.cwiseAbs2();
  EXPECT_LT((group.V.transpose() * K * group.V - Matrix(lambda.asDiagonal())).cwiseAbs().maxCoeff(),
            1e-11 * lambda.maxCoeff());
  EXPECT_EQ(group.omega.head(6), Vector::Zero(6));
  EXPECT_GT(group.omega(6), 0);
  Report report("test", Verbosity::quiet);
  ReduceSettings none;
  none.diagonal_limit = M.rows() - 1;
  EXPECT_FALSE(reduce_domains(mesh, properties(mesh, soft), MassKind::lumped, in_domains(3, 10),
                              none, report)
                   .has_diagonal_form());
}

// Ritz values in a subspace are not below those of the whole, and fall with the number of modes.
TEST(Domains, FewModesInEachAreNeverTooSoft) {
  const Mesh mesh = box_mesh({{6, 4, 4}, {6, 4, 4}, {1, 2, 3}, 0.05});
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
  const Vector full = dense_eigenpairs(Matrix(model.K), Matrix(model.M), 16).lambda;
  Vector before = Vector::Constant(16, std::numeric_limits<double>::infinity());
  for (const Index modes : {0, 3, 10, 25}) {
    const SuperelementGroup group = reduced(mesh, in_domains(4, modes));
    for (const auto& s : group.domains) EXPECT_EQ(s.k(), modes);
    const Vector lambda = group.omega.head(16).cwiseAbs2();
    for (Index j = 6; j < 16; ++j) {
      EXPECT_GE(lambda(j), full(j) * (1 - 1e-10));
      EXPECT_LE(lambda(j), before(j) * (1 + 1e-10));
    }
    before = lambda;
  }
  EXPECT_LT(before(6), 1.01 * full(6));
}

TEST(Domains, CutoffAndParticipationHoldInEach) {
  const Mesh mesh = box_mesh({{6, 4, 4}, {6, 4, 4}, {1, 2, 3}, 0.05});
  const SuperelementGroup all = reduced(mesh, in_domains(4, all_modes));
  ReductionOptions options = in_domains(4, 0);
  options.modes.reset();
  options.cutoff_hz = 12;
  const double limit = std::pow(2 * M_PI * 12, 2);
  const SuperelementGroup below = reduced(mesh, options);
  Index kept = 0;
  for (std::size_t d = 0; d < 4; ++d) {
    EXPECT_EQ(below.domains[d].k(), (all.domains[d].eigenvalues.array() < limit).count());
    kept += below.domains[d].k();
  }
  EXPECT_GT(kept, 0);
  options = in_domains(4, 5);
  options.pick = Pick::participation;
  for (const auto& s : reduced(mesh, options).domains) EXPECT_EQ(s.k(), 5);
}

TEST(Domains, MoreModesThanADomainHasAreAllOfIts) {
  const Mesh mesh = comb_mesh(4, 4);
  GroupFigures figures;
  const SuperelementGroup group = reduced(mesh, in_domains(5, 40), MassKind::lumped, &figures);
  Index elements = 0;
  for (std::size_t d = 0; d < 5; ++d) {
    EXPECT_EQ(group.domains[d].k() + figures.domains[d].modes_missing, 40);
    EXPECT_LE(group.domains[d].k(), figures.domains[d].reduction.n_interior);
    elements += figures.domains[d].n_elements;
  }
  EXPECT_EQ(elements, mesh.blocks[0].connectivity.rows());
  EXPECT_EQ(figures.domains.size(), 5u);
}

TEST(Domains, OnlySetsOfTheComponentsInterfaceAreKept) {
  // "inside" lies between two domains, and so on the interface of both.
  Mesh mesh = box_mesh({{8, 2, 2}, {8, 2, 2}, {0, 0, 0}, 0});
  const SuperelementGroup first = reduced(mesh, in_domains(2, 2));
  std::vector<Index> shared;
  for (const Index id : first.domains[0].node_ids) {
    const auto& other = first.domains[1].node_ids;
    if (std::find(other.begin(), other.end(), id) == other.end()) continue;
    shared.push_back(std::find(mesh.node_ids.begin(), mesh.node_ids.end(), id) -
                     mesh.node_ids.begin());
  }
  ASSERT_FALSE(shared.empty());
  mesh.nodesets.push_back({"inside", 9, shared});
  const Superelement whole = join(reduced(mesh, in_domains(2, 2, {"x_min", "x_max"})));
  ASSERT_EQ(whole.surfaces.size(), 2u);
  EXPECT_EQ(whole.surfaces[0].n_faces(), 4);
  EXPECT_EQ(whole.surfaces[1].name, "x_min");
  EXPECT_EQ(whole.nodesets.size(), 2u);  // corner and edge, on x_min
  EXPECT_EQ(whole.nodesets.count("inside"), 0u);
}

std::string bytes_of_group(const SuperelementGroup& group) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("cbr-group-" + std::to_string(::getpid()) + ".cbr.h5");
  write_superelement_group(group, file);
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  std::filesystem::remove(file);
  return bytes;
}

TEST(Domains, TheNumberOfThreadsDoesNotChangeAByte) {
  const Mesh mesh = box_mesh({{8, 6, 6}, {8, 6, 6}, {1, 2, 3}, 0.05});
  const int before = n_threads();
  std::vector<std::string> bytes;
  for (const int threads : {1, 2, 4, 4}) {
    set_threads(threads);
    GroupFigures figures;
    Report report("test", Verbosity::quiet);
    ReduceSettings settings;
    settings.diagonal_limit = 0;
    ReductionOptions options = in_domains(4, 15);
    options.recovery = true;
    const SuperelementGroup group = reduce_domains(mesh, properties(mesh, soft), MassKind::lumped,
                                                   options, settings, report, &figures);
    EXPECT_EQ(n_threads(), threads);
    bytes.push_back(bytes_of_group(group));
  }
  set_threads(before);
  for (const auto& other : bytes) EXPECT_TRUE(other == bytes.front());
}

TEST(Domains, ErrorsNameTheDomain) {
  const auto message = [](const Mesh& mesh, const ReductionOptions& options) -> std::string {
    return test::refusal_of([&] { reduced(mesh, options); });
  };
  const Mesh box = box_mesh({{4, 3, 2}, {4, 3, 2}, {0, 0, 0}, 0});
  EXPECT_SAYS(message(box, in_domains(25, 1)), "only 24 volume elements");
  EXPECT_SAYS(message(box, in_domains(2, 1, {"nonsense"})), "x_max");
  EXPECT_SAYS(message(box, in_domains(2, -1)), "domain 1 of 2: modes: -1");
  // A part that nothing holds, and that is a domain of its own.
  const Mesh two = both(box, box_mesh({{4, 3, 2}, {4, 3, 2}, {50, 0, 0}, 0}));
  EXPECT_SAYS(message(two, in_domains(2, 1)), "domain 2 of 2: the part of 60 nodes");
}

}  // namespace
}  // namespace cbr::test::domains_test
