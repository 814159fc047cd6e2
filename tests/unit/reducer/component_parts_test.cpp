// SPDX-License-Identifier: GPL-3.0-or-later
// A component of several parts that share no node: each has its modes, its errors and its
// tolerance.
#include "reducer/modes/component_parts.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/app/report.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/domains/domains.hpp"
#include "reducer/judgement/mode_tolerance.hpp"
#include "reducer/modes/interior_loads.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::component_parts_test {
namespace {

// One mesh of several boxes; sidesets of one name are one.
Mesh together(const std::vector<BoxSides>& boxes) {
  Mesh all;
  for (const BoxSides& box : boxes) {
    Mesh mesh = box_mesh(box);
    const Index nodes = all.coordinates.rows(), blocks = static_cast<Index>(all.blocks.size());
    const Points before = all.coordinates;
    all.coordinates.resize(nodes + mesh.coordinates.rows(), 3);
    all.coordinates << before, mesh.coordinates;
    for (const Index id : mesh.node_ids) all.node_ids.push_back(id + 100000 * blocks);
    for (Block& block : mesh.blocks) {
      block.connectivity.array() += nodes;
      block.name += std::to_string(blocks);
      block.id += blocks;
      for (Index& id : block.element_ids) id += 100000 * blocks;
      all.blocks.push_back(block);
    }
    for (Sideset& set : mesh.sidesets) {
      for (Side& side : set.sides) side.block += blocks;
      const auto same = std::find_if(all.sidesets.begin(), all.sidesets.end(),
                                     [&](const Sideset& s) { return s.name == set.name; });
      if (same == all.sidesets.end()) {
        all.sidesets.push_back(set);
      } else {
        same->sides.insert(same->sides.end(), set.sides.begin(), set.sides.end());
      }
    }
  }
  return all;
}

ReductionOptions of(std::optional<Index> modes, std::optional<double> tolerance = {}) {
  ReductionOptions options;
  options.interface_sets = {"x_min"};
  options.modes = modes;
  options.tolerance = tolerance;
  return options;
}

const BoxSides large = {{4, 4, 4}, {1, 1, 1}, {0, 0, 0}, 0},
               small = {{4, 4, 4}, {0.3, 0.3, 0.3}, {3, 0, 0}, 0};
constexpr Index all_inside = 3 * 4 * 25;

// E of the interior's strain energy under rigid accelerations of these interface nodes that modes
// hold   (6 x 6)
Matrix energy_held(const Superelement& s, const std::vector<Index>& nodes) {
  Points x = s.coordinates(nodes, Eigen::all);
  x.rowwise() -= Eigen::RowVector3d(3.15, 0.15, 0.15);
  std::vector<Index> dofs = dofs_of(nodes);
  const Matrix B = s.eigenvalues.cwiseSqrt().cwiseInverse().asDiagonal() *
                   Matrix(Matrix(s.M_kc(Eigen::all, dofs)) * rigid_modes(x, Vector3::Zero()));
  return B.transpose() * B;
}

// The small cube's modes are far above those of the large one, which six whole-body motions and ten
// modes of both are all of.
TEST(ComponentParts, AToleranceBoundsTheErrorsOfEachPart) {
  const Mesh mesh = together({large, small});
  const Superelement alone = reduced(box_mesh(small), of(all_inside));
  std::vector<Index> own_nodes(25), nodes;
  for (Index i = 0; i < 25; ++i) own_nodes[i] = i;
  const Matrix E = energy_held(alone, own_nodes);
  for (const double tolerance : {0.1, 1e-2}) {
    const Superelement s = reduced(mesh, of({}, tolerance));
    nodes.clear();
    for (Index i = 0; i < s.coordinates.rows(); ++i)
      if (s.coordinates(i, 0) > 2) nodes.push_back(i);
    const SymmetricEigen left = generalized_eigen(Matrix(E - energy_held(s, nodes)), E);
    EXPECT_LE(left.values(5), tolerance * (1 + 1e-6));
    // or the large cube's
    EXPECT_NEAR(s.accuracy->largest_left_out, left.values(5), 0.5 * tolerance);
    EXPECT_LE(s.accuracy->largest_left_out, tolerance * (1 + 1e-6));
    // Elastic modes that move the small cube
    Index found = 0;
    for (Index j = 12; j < s.n() && found < 10; ++j) {
      const Vector u = s.V.col(j).tail(s.c());
      if (Vector(u(dofs_of(nodes))).squaredNorm() < 0.5 * u.squaredNorm()) continue;
      EXPECT_LE(1 - std::pow(alone.omega(6 + found) / s.omega(j), 2), tolerance * (1 + 1e-6))
          << found;
      ++found;
    }
    EXPECT_EQ(found, 10);
  }
}

TEST(ComponentParts, EstimatedErrorsAreTheTrueOnes) {
  const Mesh mesh = together({large, small});
  const Superelement all = reduced(mesh, of(2 * all_inside));
  ReductionOptions options = of(30);
  for (const Pick pick : {Pick::frequency, Pick::participation}) {
    options.pick = pick;
    const Superelement s = reduced(mesh, options);
    const Superelement::Accuracy& a = *s.accuracy;
    ASSERT_GE(
        a.eigenvalue_error.size(),
        pick == Pick::frequency ? 6 : 2);  // the others are not below the first that was dropped
    for (Index j = 0; j < std::min<Index>(10, a.eigenvalue_error.size()); ++j) {
      EXPECT_NEAR(a.frequency_hz(j), s.omega(12 + j) / (2 * M_PI), 1e-8 * a.frequency_hz(j));
      const double truth = 1 - std::pow(all.omega(12 + j) / s.omega(12 + j), 2);
      EXPECT_GT(a.eigenvalue_error(j), 0.95 * truth - 1e-9) << j;
      EXPECT_LT(a.eigenvalue_error(j), 1.6 * truth + 1e-9) << j;
    }
    EXPECT_LE(a.covered_hz, a.complete_hz);
  }
}

// Six times each eigenvalue of one part: a solver of all parts at once would have to find six-fold
// ones.
TEST(ComponentParts, EqualPartsHaveTheModesOfOne) {
  std::vector<BoxSides> boxes;
  for (int i = 0; i < 6; ++i) boxes.push_back({{5, 5, 5}, {1, 0.9, 0.8}, {2.0 * i, 0, 0}, 0});
  const Mesh mesh = together(boxes);
  const Superelement one = reduced(box_mesh(boxes[0]), of(8));
  for (const Index modes : {0, 1, 6, 13, 48}) {
    ReductionOptions options = of(modes);
    options.recovery = true;
    ReductionFigures figures;
    const Superelement s = reduced(mesh, options, MassKind::lumped, &figures);
    ASSERT_EQ(s.k(), modes);
    EXPECT_TRUE(figures.modes_proven);
    for (Index j = 0; j < modes; ++j)
      EXPECT_NEAR(s.eigenvalues(j), one.eigenvalues(j / 6), 1e-9 * one.eigenvalues(j / 6)) << j;
  }
  ReductionOptions massless = of(7);
  massless.basis = Basis::massless;
  const Superelement lone = reduced(box_mesh(boxes[0]), massless);
  massless.modes = 42;
  const Superelement s = reduced(mesh, massless);
  ASSERT_EQ(s.k(), 36 + 42);
  for (Index j = 0; j < 42; ++j)
    EXPECT_NEAR(s.eigenvalues(36 + j), lone.eigenvalues(6 + j / 6),
                1e-8 * lone.eigenvalues(6 + j / 6))
        << j;
}

TEST(ComponentParts, ResidualVectorsMoveOnePartEach) {
  const Mesh mesh = together({large, small});
  ReductionOptions options = of(10);
  options.loads = {"x_max"};
  options.recovery = true;
  const Superelement s = reduced(mesh, options);
  EXPECT_EQ(s.n_residual, 6);
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
  const Partition p = partition(model, interface_nodes(mesh, model, {"x_min"}));
  const Matrix& Phi = s.recovery.at(0).Phi;
  EXPECT_LT((Phi.transpose() * p.M_II * Phi - Matrix::Identity(16, 16)).cwiseAbs().maxCoeff(),
            1e-9);
  const Vector root = s.eigenvalues.cwiseSqrt().cwiseInverse();
  const Matrix K = root.asDiagonal() * Matrix(Phi.transpose() * p.K_II * Phi) * root.asDiagonal();
  EXPECT_LT((K - Matrix::Identity(16, 16)).cwiseAbs().maxCoeff(), 1e-9);
  // Statics under the load are exact: F^T K_II^-1 F
  const Matrix F = interior_loads(mesh, model, p, {"x_max"}).F_I,
               u = SparseCholesky(p.K_II).solve(F);
  const Matrix held = s.loads.at("x_max").force.topRows(16);
  const Matrix compliance = held.transpose() * s.eigenvalues.cwiseInverse().asDiagonal() * held;
  EXPECT_LT((compliance - F.transpose() * u).cwiseAbs().maxCoeff(),
            1e-9 * compliance.cwiseAbs().maxCoeff());
}

TEST(ComponentParts, TheCouplingByOnePsiIsThatOfTheCondensation) {
  const Mesh mesh = together({large, small});
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::consistent);
  Partition p = partition(model, interface_nodes(mesh, model, {"x_min"}));
  const SparseCholesky factor(p.K_II);
  Report report("test", Verbosity::quiet);
  const Matrix Phi = fixed_interface_modes(p, factor, 12, report).Phi;
  CondensationOptions options;
  options.one_Psi = true;
  options.panel = 17;
  const Condensation c = condense(p, factor, Phi, options, report);
  EXPECT_EQ(mode_coupling_of_one_Psi(p, factor, Phi, options, report), c.M_kc);
}

TEST(ModeTolerance, TellsWhereItIsNotMet) {
  Report report("test", Verbosity::quiet);
  const auto said = [&](double left_out, double mode_error) {
    testing::internal::CaptureStderr();
    judge_tolerance(1e-3, left_out, mode_error, 1e12, report);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(said(1e-3, 9e-4), "");
  EXPECT_SAYS(said(2e-3, 9e-4), "leave 0.002 of the strain energy");
  EXPECT_SAYS(said(1e-4, 5e-3), "ten lowest eigenvalues is too high by 0.005");
  EXPECT_SAYS(said(NAN, 0), "tolerance: 0.001 is not met");
}

// Most of a domain's interface is no concern of the user's.
TEST(Domains, HaveNoErrorsOfTheirOwn) {
  const Mesh mesh = box_mesh({{6, 3, 3}, {2, 1, 1}, {0, 0, 0}, 0});
  Report report("test", Verbosity::quiet);
  for (const bool by_tolerance : {false, true}) {
    ReductionOptions options = by_tolerance ? of({}, 0.1) : of(5);
    options.domains = 2;
    const SuperelementGroup group = reduce_domains(mesh, properties(mesh, soft), MassKind::lumped,
                                                   options, {}, report, nullptr);
    ASSERT_EQ(group.domains.size(), 2U);
    for (const Superelement& domain : group.domains) {
      EXPECT_FALSE(domain.accuracy);
      EXPECT_GT(domain.k(), 0);
    }
  }
}

}  // namespace
}  // namespace cbr::test::component_parts_test
