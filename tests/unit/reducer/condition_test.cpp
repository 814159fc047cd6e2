// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/condition.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>

#include "common/error.hpp"
#include "common/linalg/eigenpairs.hpp"
#include "reducer/reduce.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test {
namespace {

const Material soft = {1000, 0.3, 2};

double norm_1(const Matrix& A) { return A.cwiseAbs().colwise().sum().maxCoeff(); }

// A component and its partition, held at x_min.
struct Held {
  Mesh mesh = box_mesh({{4, 3, 2}, {4, 3, 2}, {1, 2, 3}, 0.08});
  FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
  Partition p = partition(model, interface_nodes(mesh, model, {"x_min"}));
  SparseCholesky factor{p.K_II};
  Eigenpairs modes = dense_eigenpairs(Matrix(p.K_II), Matrix(p.M_II), 12);
};

Superelement reduced(const Mesh& mesh, std::vector<std::string> sets, Index k, ReductionFigures& figures, Report& report) {
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
      const Matrix A = D.asDiagonal() * (B * B.transpose() + 0.01 * Matrix::Identity(n, n)) * D.asDiagonal();
      const Eigen::LLT<Matrix> llt(A);
      const double truth = norm_1(A.inverse()), found = inverse_norm(n, [&](Vector&x) { llt.solveInPlace(x); });
      EXPECT_LE(found, truth * (1 + 1e-6));
      EXPECT_GE(found, truth / 3);
    }
  }
}

TEST(ConditionNumbers, ScaledDoesNotDependOnUnits) {
  const Held held;
  const ConditionNumbers numbers = condition_numbers(held.p.K_II, held.factor);
  const double truth = norm_1(Matrix(held.p.K_II)) * norm_1(Matrix(held.p.K_II).inverse());
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
    const double truth = norm_1(M) * norm_1(M.inverse()), found = reduced_mass_condition(s).plain;
    EXPECT_LE(found, truth * (1 + 1e-9));
    EXPECT_GE(found, truth / 3);
  }
  Superelement s = reduced(held.mesh, {"x_min"}, 2, figures, report);
  s.M_kc *= 100;  // more mass coupled than there is
  EXPECT_TRUE(std::isinf(reduced_mass_condition(s).plain));
}

TEST(CheckModes, SoundOnesPass) {
  const Held held;
  const ModeCheck check = check_modes(held.p, held.modes.lambda, held.modes.Phi);
  EXPECT_LT(check.orthogonality, 1e-12);
  EXPECT_LT(check.residual, 1e-10);
  EXPECT_NO_THROW(require_independent(held.p, held.modes.Phi, check));
}

TEST(CheckModes, AModeThatIsThereTwiceIsNamed) {
  Held held;
  held.modes.Phi.col(8) = held.modes.Phi.col(4);
  const ModeCheck check = check_modes(held.p, held.modes.lambda, held.modes.Phi);
  EXPECT_GT(check.orthogonality, 0.5);
  try {
    require_independent(held.p, held.modes.Phi, check);
    FAIL() << "no error";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("modes 5 and 9"), std::string::npos) << error.what();
  }
}

TEST(CheckModes, AVectorThatIsNoModeShowsInTheResidual) {
  Held held;
  held.modes.lambda(3) *= 1.01;
  EXPECT_GT(check_modes(held.p, held.modes.lambda, held.modes.Phi).residual, 1e-4);
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

TEST(ReductionCondition, IsFilledAndQuietWhereAllIsWell) {
  const Mesh mesh = box_mesh({{8, 6, 5}, {4, 3, 2}, {0, 0, 0}, 0.05});
  ReductionFigures figures;
  Report report("test", Verbosity::quiet);
  const Superelement s = reduced(mesh, {"x_min"}, 30, figures, report);
  const ReductionCondition& c = figures.condition;
  EXPECT_EQ(report.n_warnings(), 0);
  EXPECT_GT(c.K_II.scaled, 10);
  EXPECT_GT(c.mass.plain, 1);
  EXPECT_LT(c.modes.orthogonality, 1e-10);
  EXPECT_NE(c.counts.find(" found"), std::string::npos) << c.counts;
  EXPECT_LT(c.reduced_rigid, 1e-12);
  EXPECT_EQ(c.n_zero, 6);
  EXPECT_EQ(c.n_rigid, 6);
  EXPECT_EQ(c.largest_omega, s.omega(s.n() - 1));
}

TEST(ReductionCondition, AMechanismAmongTheKeptNodesIsNamed) {
  // A second block on an edge of the first; all nodes are kept, so that no solve meets the hinge.
  Mesh mesh = both(box_mesh({{2, 2, 2}, {2, 2, 2}, {0, 0, 0}, 0}), box_mesh({{2, 2, 2}, {2, 2, 2}, {2, 2, 0}, 0}));
  for (Index& node : mesh.blocks[1].connectivity.reshaped()) {
    const Vector3 x = mesh.coordinates.row(node);
    if (x(0) == 2 && x(1) == 2) node = 2 + 3 * (2 + 3 * static_cast<Index>(x(2)));
  }
  const FiniteElementModel model = number_nodes(mesh);
  mesh.nodesets.push_back({"all", 9, model.nodes});
  ReductionFigures figures;
  Report report("test", Verbosity::quiet);
  reduced(mesh, {"all"}, 0, figures, report);
  EXPECT_EQ(figures.condition.n_rigid, 6);
  EXPECT_EQ(figures.condition.n_zero, 7);
  EXPECT_NE(figures.condition.loose_node.find("of block '"), std::string::npos) << figures.condition.loose_node;
  EXPECT_GE(report.n_warnings(), 1);
}

}  // namespace
}  // namespace cbr::test
