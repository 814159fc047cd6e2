// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/judgement/condition_numbers.hpp"
#include "common/linalg/dense.hpp"
#include "common/scene/scene_words.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "common/base/error.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::condition_numbers_test {
namespace {

double norm_1(const Matrix& A) { return A.cwiseAbs().colwise().sum().maxCoeff(); }

// A component and its partition, held at x_min.
struct Held {
  Mesh mesh = box_mesh({{4, 3, 2}, {4, 3, 2}, {1, 2, 3}, 0.08});
  FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
  Partition p = partition(model, interface_nodes(mesh, model, {"x_min"}));
  SparseCholesky factor{p.K_II};
  Eigenpairs modes = dense_eigenpairs(Matrix(p.K_II), Matrix(p.M_II), 12);

  LocalInterior interior() const { return {p, factor}; }
};

Superelement reduced(const Mesh& mesh, std::vector<std::string> sets, Index k,
                     ReductionFigures& figures, Report& report) {
  ReductionOptions options;
  options.interface_sets = std::move(sets);
  options.modes = k;
  return reduce(mesh, properties(mesh, soft), MassKind::lumped, options, {}, report, &figures);
}

TEST(InverseNorm, IsALowerBoundWithinAFactorOfThree) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const Index n : {Index{1}, Index{2}, Index{7}, Index{40}}) {
    for (int round = 0; round < 20; ++round) {
      const Matrix B = Matrix::NullaryExpr(n, n, [&] { return normal(random); });
      const Vector D = Vector::NullaryExpr(n, [&] { return std::pow(10, 3 * normal(random)); });
      const Matrix A =
          D.asDiagonal() * (B * B.transpose() + 0.01 * Matrix::Identity(n, n)) * D.asDiagonal();
      const Cholesky cholesky(A);
      const double truth = norm_1(Lu(A).inverse()),
                   found = inverse_norm(n, [&](Vector&x) { cholesky.solve_in_place(x); });
      EXPECT_LE(found, truth * (1 + 1e-6));
      EXPECT_GE(found, truth / 3);
    }
  }
}

TEST(ConditionNumbers, ScaledDoesNotDependOnUnits) {
  const Held held;
  const ConditionNumbers numbers = condition_numbers(held.p.K_II, held.factor);
  const double truth = norm_1(Matrix(held.p.K_II)) * norm_1(Lu(Matrix(held.p.K_II)).inverse());
  EXPECT_LE(numbers.plain, truth * (1 + 1e-9));
  EXPECT_GE(numbers.plain, truth / 3);
  // Half of the dofs in another unit
  Vector unit = Vector::Ones(held.p.n_interior());
  for (Index i = 0; i < unit.size(); i += 2) unit(i) = 1e5;
  const SparseMatrix K = unit.asDiagonal() * held.p.K_II * unit.asDiagonal();
  const ConditionNumbers other = condition_numbers(K, SparseCholesky(K));
  EXPECT_GT(other.plain, 1e6 * numbers.plain);
  EXPECT_NEAR(other.scaled, numbers.scaled, 1e-6 * numbers.scaled);
}

TEST(ReducedMassCondition, IsThatOfTheDenseMatrix) {
  const Held held;
  ReductionFigures figures;
  Report report("test", Verbosity::quiet);
  for (const Index k : {Index{0}, Index{6}}) {
    const Superelement s = reduced(held.mesh, {"x_min", "z_max"}, k, figures, report);
    const Matrix M = reduced_mass(s);
    const double truth = norm_1(M) * norm_1(Lu(M).inverse()),
                 found = reduced_mass_condition(s).plain;
    EXPECT_LE(found, truth * (1 + 1e-9));
    EXPECT_GE(found, truth / 3);
  }
  Superelement s = reduced(held.mesh, {"x_min"}, 2, figures, report);
  s.M_kc *= 100;  // more mass coupled than there is
  EXPECT_TRUE(std::isinf(reduced_mass_condition(s).plain));
}

TEST(CheckModes, SoundOnesPass) {
  const Held held;
  const ModeCheck check = check_modes(held.interior(), held.modes.lambda, held.modes.Phi);
  EXPECT_LT(check.orthogonality, 1e-12);
  EXPECT_LT(check.residual, 1e-10);
  EXPECT_NO_THROW(require_independent(held.interior(), held.modes.Phi, check));
}

TEST(CheckModes, AModeThatIsThereTwiceIsNamed) {
  Held held;
  held.modes.Phi.col(8) = held.modes.Phi.col(4);
  const ModeCheck check = check_modes(held.interior(), held.modes.lambda, held.modes.Phi);
  EXPECT_GT(check.orthogonality, 0.5);
  EXPECT_SAYS(test::refusal_of<RunError>(
                  [&] { require_independent(held.interior(), held.modes.Phi, check); }),
              "modes 5 and 9");
}

TEST(CheckModes, AVectorThatIsNoModeShowsInTheResidual) {
  Held held;
  held.modes.lambda(3) *= 1.01;
  EXPECT_GT(check_modes(held.interior(), held.modes.lambda, held.modes.Phi).residual, 1e-4);
}

TEST(RigidResidual, ASpringToTheGroundIsFound) {
  const Held held;
  const Matrix R = rigid_modes(held.mesh.coordinates, Vector3(3, 3.5, 4));
  EXPECT_LT(rigid_residual(held.model.K, R).value, 1e-14);
  SparseMatrix K = held.model.K;
  K.coeffRef(31, 31) *= 1.001;
  const RigidResidual found = rigid_residual(K, R);
  EXPECT_GT(found.value, 1e-5);
  EXPECT_EQ(found.row, 31);
  EXPECT_EQ(rigid_residual(Matrix(K), R).row, 31);
}

TEST(Conditioning, IsFilledAndQuietWhereAllIsWell) {
  const Mesh mesh = box_mesh({{8, 6, 5}, {4, 3, 2}, {0, 0, 0}, 0.05});
  ReductionFigures figures;
  Report report("test", Verbosity::quiet);
  const Superelement s = reduced(mesh, {"x_min"}, 30, figures, report);
  const Conditioning& c = figures.condition;
  EXPECT_EQ(report.n_warnings(), 0);
  EXPECT_GT(c.K_II.scaled, 10);
  EXPECT_GT(c.mass.plain, 1);
  EXPECT_LT(c.modes.orthogonality, 1e-10);
  EXPECT_SAYS(c.counts, " found");
  EXPECT_LT(c.reduced_rigid, 1e-12);
  EXPECT_EQ(c.n_zero, 6);
  EXPECT_EQ(c.n_rigid, 6);
  EXPECT_EQ(c.largest_omega, s.omega(s.n() - 1));
}

// A second block on an edge of the first: it turns about that edge.
Mesh hinged() {
  Mesh mesh = both(box_mesh({{2, 2, 2}, {2, 2, 2}, {0, 0, 0}, 0}),
                   box_mesh({{2, 2, 2}, {2, 2, 2}, {2, 2, 0}, 0}));
  for (Index& node : mesh.blocks[1].connectivity.reshaped()) {
    const Vector3 x = mesh.coordinates.row(node);
    if (x(0) == 2 && x(1) == 2) node = 2 + 3 * (2 + 3 * static_cast<Index>(x(2)));
  }
  // All nodes are kept, so that no solve meets the hinge.
  mesh.nodesets.push_back({"all", 9, number_nodes(mesh).nodes});
  return mesh;
}

TEST(Conditioning, AMechanismAmongTheKeptNodesIsNamed) {
  ReductionFigures figures;
  Report report("test", Verbosity::quiet);
  reduced(hinged(), {"all"}, 0, figures, report);
  EXPECT_EQ(figures.condition.n_rigid, 6);
  EXPECT_EQ(figures.condition.n_zero, 7);
  EXPECT_SAYS(figures.condition.loose_node, "of block '");
  EXPECT_GE(report.n_warnings(), 1);
}

// 2 x 2 x 2 hexes; nodeset "all" has all nodes.
Mesh all_of_a_box() {
  Mesh mesh = box_mesh({{2, 2, 2}, {2, 2, 2}, {0, 0, 0}, 0});
  mesh.nodesets.push_back({"all", 9, number_nodes(mesh).nodes});
  return mesh;
}

TEST(Conditioning, OfTheCharacteristicBasisIsItsOwn) {
  ReductionOptions options;
  options.interface_sets = {"all"};
  options.modes = 0;
  options.basis = Basis::characteristic;
  for (const auto& [is_hinged, n_modes] :
       {std::pair(true, 12), std::pair(true, 1), std::pair(false, 12)}) {
    // one is enough for the mechanism, which has the frequency of the rigid motions
    options.characteristic.modes = n_modes;
    const Mesh mesh = is_hinged ? hinged() : all_of_a_box();
    ReductionFigures figures;
    Report report("test", Verbosity::quiet);
    testing::internal::CaptureStderr();
    const Superelement s = reduce(mesh, properties(mesh, paper_steel()), MassKind::lumped, options,
                                  {}, report, &figures);
    const std::string text = testing::internal::GetCapturedStderr();
    const Conditioning& c = figures.condition;
    EXPECT_EQ(c.n_rigid, 6);
    EXPECT_EQ(c.n_zero, is_hinged ? 7 : 6);
    EXPECT_EQ(c.loose_node.find("of block '") != std::string::npos, is_hinged) << c.loose_node;
    EXPECT_EQ(text.find("beside its 6 rigid ones: a mechanism") != std::string::npos, is_hinged)
        << text;
    EXPECT_EQ(c.largest_omega * c.largest_omega, s.eigenvalues.maxCoeff());
    EXPECT_GE(c.mass.scaled, 1);
    // Rigid motions are in the shapes to the last digit: V_r X = R, X^-T X^-1 their inertia
    const Matrix R = reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c()),
                 V_r = s.characteristic.V.leftCols(c.n_zero);
    const Matrix X = PivotedQr(V_r).solve(R);
    EXPECT_LT((V_r * X - R).cwiseAbs().maxCoeff(), 1e-14 * R.cwiseAbs().maxCoeff());
    EXPECT_NEAR((X.transpose() * X)(2, 2), s.rigid_body.mass, 1e-13 * s.rigid_body.mass);
  }
}

TEST(Conditioning, AMechanismIsFoundWithoutTheDiagonalForm) {
  ReductionOptions options;
  options.interface_sets = {"all"};
  options.modes = 0;
  ReduceSettings settings;
  settings.diagonal_limit = 0;
  for (const bool is_hinged : {true, false}) {
    const Mesh mesh = is_hinged ? hinged() : all_of_a_box();
    ReductionFigures figures;
    Report report("test", Verbosity::quiet);
    testing::internal::CaptureStderr();
    reduce(mesh, properties(mesh, paper_steel()), MassKind::lumped, options, settings, report,
           &figures);
    const std::string text = testing::internal::GetCapturedStderr();
    const Conditioning& c = figures.condition;
    EXPECT_EQ(text.find("a mechanism") != std::string::npos, is_hinged) << text;
    EXPECT_EQ(c.loose_node.find("of block '") != std::string::npos, is_hinged) << c.loose_node;
    EXPECT_EQ(c.softest < 1e-13, is_hinged) << c.softest;
    EXPECT_EQ(c.softest > 1e-3, !is_hinged) << c.softest;
    EXPECT_GT(c.mass.plain, 1);  // known without the form too
    EXPECT_FALSE(c.knows_frequencies());
    options.basis = Basis::massless;
    options.massless_modes = MasslessModes::free;
    options.modes = 12;
    if (is_hinged) {
      EXPECT_SAYS(test::refusal_of([&] {
                    reduce(mesh, properties(mesh, paper_steel()), MassKind::lumped, options,
                           settings, report, &figures);
                  }),
                  "moves most at node");
    }
    options.basis = Basis::craig_bampton;
    options.modes = 0;
  }
}

// x^T D K D x of the softest motion beside the rigid ones, against all eigenvalues.
TEST(SoftestMotion, IsTheLowestEigenvalueOfTheScaledMatrixWhereItIsFarBelowTheOthers) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const Index n = 40;
  const Matrix Q = orthonormal_basis(Matrix::NullaryExpr(n, n, [&] { return normal(random); }));
  for (const double lowest : {1e-6, 1e-9, 0.0}) {
    Vector lambda = Vector::LinSpaced(n, 1, 2);
    lambda.head(3).setZero();
    lambda(3) = lowest;
    const Matrix K = Q * lambda.asDiagonal() * Q.transpose();
    const Matrix N = orthonormal_basis(Q.leftCols(3));
    const SoftestMotion found = softest_motion(K, N);
    // Of D K D between the scales of its smallest and largest diagonal entry
    EXPECT_GE(found.stiffness, lowest / K.diagonal().maxCoeff() - 1e-14);
    EXPECT_LE(found.stiffness, 1.01 * lowest / K.diagonal().minCoeff() + 1e-14);
    EXPECT_GE(found.dof, 0);
  }
}

TEST(Conditioning, WhatIsNotComputedIsNotTold) {
  testing::internal::CaptureStderr();
  Report report("test", Verbosity::verbose);
  const Conditioning nothing;
  report_conditioning(nothing, report);
  warn_of_conditioning(nothing, report);
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(report.n_warnings(), 0);
  for (const char* line :
       {"condition of K_II: not computed", "condition of the reduced mass: not computed",
        "modes: not checked", "forces of K not computed", "reduced frequencies: not computed"})
    EXPECT_SAYS(text, line) << line;
}

// A soft half, held by the interface at x_min, and a stiff one: by round-off of the stiff one the
// interior lags behind, by 5e-4 at a ratio of 1e10 and more than the body itself at 1e14.
Superelement soft_and_stiff(double ratio, Basis basis, Report& report) {
  Mesh mesh = box_mesh({{8, 3, 3}, {2, 1, 1}, {0, 0, 0}, 0});
  Block& first = mesh.blocks[0];
  Block second = first;
  second.name = "stiff";
  second.id = 2;
  std::vector<Index> row(first.connectivity.rows()), rows[2];
  for (Index e = 0; e < first.connectivity.rows(); ++e) {
    auto& half = rows[e % 8 < 4 ? 0 : 1];
    row[e] = static_cast<Index>(half.size());
    half.push_back(e);
  }
  second.connectivity = IndexTable(first.connectivity(rows[1], Eigen::all));
  first.connectivity = IndexTable(first.connectivity(rows[0], Eigen::all));
  second.element_ids.resize(rows[1].size());
  for (std::size_t i = 0; i < rows[1].size(); ++i)
    second.element_ids[i] = first.element_ids[rows[1][i]];
  first.element_ids.resize(rows[0].size());
  for (std::size_t i = 0; i < rows[0].size(); ++i) first.element_ids[i] = rows[0][i] + 1;
  mesh.blocks.push_back(second);
  Sideset face = mesh.sidesets.at(0);
  for (Side& side : face.sides) side.element = row[side.element];
  mesh.sidesets = {face};
  mesh.nodesets.clear();
  ReductionOptions options;
  options.interface_sets = {face.name};
  options.modes = basis == Basis::massless ? 30 : 384;
  options.basis = basis;
  if (basis == Basis::characteristic) options.characteristic.modes = 30;
  const BlockProperties a{{1 / ratio, 0.3, 1 / ratio}, HexFormulation::incompatible};
  const BlockProperties b{{1, 0.3, 8 / ratio}, HexFormulation::incompatible};
  return reduce(mesh, {a, b}, MassKind::lumped, options, {}, report);
}

// One criterion for all forms. The lowest frequencies, whose soft half alone is bent, do not depend
// on the ratio beyond 1e6 but for 1e-6 of them.
TEST(Conditioning, StiffPartsAreRefusedWhereAllIsLostAndByAllFormsAlike) {
  Report report("test", Verbosity::quiet);
  for (const auto& [word, basis] : basis_words) {
    const auto lowest = [&, basis = basis](double ratio) {
      const Superelement s = soft_and_stiff(ratio, basis, report);
      return s.has_diagonal_form() ? Vector(s.omega.segment(6, 3))
                                   : Vector(s.eigenvalues.segment(6, 3).cwiseSqrt());
    };
    testing::internal::CaptureStderr();
    const Vector known = lowest(1e6), found = lowest(1e10);
    EXPECT_SAYS(testing::internal::GetCapturedStderr(), "which is put right") << word;
    // 1.5e-5 is measured
    EXPECT_LT((found - known).cwiseQuotient(known).cwiseAbs().maxCoeff(), 6e-5) << word;
    testing::internal::CaptureStderr();
    EXPECT_THROW(soft_and_stiff(1e14, basis, report), InputError) << word;
    EXPECT_EQ(testing::internal::GetCapturedStderr().find("put right"), std::string::npos) << word;
  }
}

TEST(UnjoinedParts, NodesOfTwoPartsAtOnePlaceAreTold) {
  const Mesh first = box_mesh({{2, 2, 2}, {2, 2, 2}, {0, 0, 0}, 0});
  const auto told = [](const Mesh& mesh) {
    const FiniteElementModel model = number_nodes(mesh);
    return unjoined_parts(mesh, model, connected_parts(mesh, model));
  };
  EXPECT_EQ(told(first), "");
  EXPECT_EQ(told(both(first, box_mesh({{2, 2, 2}, {2, 2, 2}, {2.5, 0, 0}, 0}))), "");  // apart
  EXPECT_SAYS(told(both(first, box_mesh({{2, 2, 2}, {2, 2, 2}, {2, 0, 0}, 0}))),
              "2 parts that share no node, and 9 pairs of nodes");
}

TEST(UnjoinedParts, RoundedCoordinatesAreOnePlaceByTheElementsThere) {
  // Edges of 1 in the first, of 1e-3 in the second: a thousandth of the shorter one
  const Mesh first = box_mesh({{2, 2, 2}, {2, 2, 2}, {0, 0, 0}, 0});
  const auto pairs = [&](const Mesh& mesh) {
    const FiniteElementModel model = number_nodes(mesh);
    return near_nodes(mesh, model, connected_parts(mesh, model));
  };
  for (const double apart : {0.0, 3e-7, -9e-4, 1.1e-3}) {
    const Mesh mesh = both(first, box_mesh({{2, 2, 2}, {2, 2, 2}, {2 + apart, 0, 0}, 0}));
    EXPECT_EQ(pairs(mesh).size(), apart < 1e-3 ? 9u : 0u) << apart;
    for (const NearNodes& pair : pairs(mesh)) EXPECT_NEAR(pair.apart, std::abs(apart), 1e-15);
  }
  for (const double apart : {3e-7, 1.1e-6}) {
    const Mesh mesh = both(first, box_mesh({{2, 2, 2}, {2e-3, 2e-3, 2e-3}, {2 + apart, 0, 0}, 0}));
    EXPECT_EQ(pairs(mesh).size(), apart < 1e-6 ? 1u : 0u) << apart;
  }
  const Mesh mesh = both(first, box_mesh({{2, 2, 2}, {2, 2, 2}, {2, 3e-7, 0}, 0}));
  const FiniteElementModel model = number_nodes(mesh);
  const std::vector<Index> part = connected_parts(mesh, model);
  EXPECT_SAYS(unjoined_parts(mesh, model, part), "only 3e-07 apart");
  EXPECT_SAYS(several_parts(mesh, model, part), "2 parts that share no node");
  EXPECT_EQ(several_parts(first, number_nodes(first), connected_parts(first, number_nodes(first))),
            "");
}

TEST(UnjoinedParts, PairsAreThoseOfAllPairsLookedAt) {
  // Two clouds of small boxes, some nearly touching: every pair against every other
  Mesh mesh = box_mesh({{3, 3, 1}, {3, 3, 0.01}, {0, 0, 0}, 0.2});
  mesh = both(mesh, box_mesh({{6, 5, 2}, {3, 3, 0.001}, {0, 0, 0.010003}, 0.01}));
  const FiniteElementModel model = number_nodes(mesh);
  const std::vector<Index> part = connected_parts(mesh, model);
  std::vector<double> edge(model.nodes.size(), 1e9);
  for (const Block& block : mesh.blocks)
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      double shortest = 1e9;
      for (Index a = 0; a < 8; ++a)
        for (Index b = 0; b < a; ++b)
          shortest = std::min(shortest, (mesh.coordinates.row(block.connectivity(e, a)) -
                                         mesh.coordinates.row(block.connectivity(e, b)))
                                            .norm());
      for (const Index node : block.connectivity.row(e))
        edge[model.row[node]] = std::min(edge[model.row[node]], shortest);
    }
  std::set<std::pair<Index, Index>> expected, found;
  for (Index i = 0; i < std::ssize(part); ++i)
    for (Index j = i + 1; j < std::ssize(part); ++j)
      if (part[i] != part[j] &&
          (mesh.coordinates.row(model.nodes[i]) - mesh.coordinates.row(model.nodes[j])).norm() <=
              1e-3 * std::min(edge[i], edge[j]))
        expected.insert({i, j});
  for (const NearNodes& pair : near_nodes(mesh, model, part))
    found.insert({pair.first, pair.second});
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace cbr::test::condition_numbers_test
