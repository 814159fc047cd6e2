// SPDX-License-Identifier: GPL-3.0-or-later
// What a reduction says of its own errors, held against the full model.
#include "reducer/judgement/accuracy.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/judgement/mode_tolerance.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::accuracy_test {
namespace {

Mesh block() { return box_mesh({{6, 4, 3}, {6, 4, 3}, {1, 2, 3}, 0.05}); }

ReductionOptions of(std::vector<std::string> sets) {
  ReductionOptions options;
  options.interface_sets = std::move(sets);
  return options;
}

struct Full {
  FiniteElementModel model;
  Partition p;
  Vector eigenvalues;
};

Full full(const Mesh& mesh, const std::vector<std::string>& sets, MassKind mass) {
  Full f;
  f.model = assemble(mesh, properties(mesh, soft), mass);
  f.p = partition(f.model, interface_nodes(mesh, f.model, sets));
  f.eigenvalues = dense_eigenpairs(Matrix(f.model.K), Matrix(f.model.M), f.model.K.rows()).lambda;
  return f;
}

class Accuracy : public testing::TestWithParam<MassKind> {};
INSTANTIATE_TEST_SUITE_P(Masses, Accuracy, testing::Values(MassKind::lumped, MassKind::consistent));

TEST_P(Accuracy, EstimatedErrorsOfEigenvaluesAreTheTrueOnes) {
  const Mesh mesh = block();
  for (const auto& sets : {std::vector<std::string>{"x_max"}, {"x_min", "z_max"}}) {
    const Full f = full(mesh, sets, GetParam());
    ReductionOptions options = of(sets);
    options.modes = 60;
    const Superelement s = reduced(mesh, options, GetParam());
    ASSERT_TRUE(s.accuracy);
    ASSERT_GE(s.accuracy->frequency_hz.size(), 10);
    int compared = 0;
    for (Index j = 0; j < s.accuracy->frequency_hz.size(); ++j) {
      const double lambda = s.omega(6 + j) * s.omega(6 + j),
                   truth = 1 - f.eigenvalues(6 + j) / lambda;
      EXPECT_NEAR(s.accuracy->frequency_hz(j), s.omega(6 + j) / (2 * std::numbers::pi),
                  1e-9 * s.accuracy->frequency_hz(j));
      if (s.accuracy->eigenvalue_error(j) > 0.05) break;
      // From above, but for modes beyond those that are looked at, which take part in the highest
      EXPECT_GT(s.accuracy->eigenvalue_error(j), (j < 10 ? 0.99 : 0.9) * truth) << j;
      EXPECT_LT(s.accuracy->eigenvalue_error(j), 1.4 * truth) << j;
      ++compared;
    }
    EXPECT_GE(compared, 10);
  }
}

// Of slender parts the strain energy of rigid accelerations is nearly all in the first modes,
// beside which what is missing is lost in round-off where it is a difference. The reference keeps
// all modes: of the full K and M the lowest eigenvalues are round-off.
TEST(AccuracyOfSlenderParts, EstimatedErrorsOfEigenvaluesAreTheTrueOnes) {
  struct Case {
    BoxSides box;
    std::array<Index, 2> modes;
  };
  for (const Case& c : {Case{{{60, 1, 1}, {30, 1, 1}, {0, 0, 0}, 0}, {12, 30}},
                        Case{{{80, 1, 1}, {300, 1, 1}, {0, 0, 0}, 0}, {12, 30}},
                        Case{{{8, 8, 1}, {1, 1, 0.01}, {0, 0, 0}, 0}, {20, 40}}}) {
    const Mesh mesh = box_mesh(c.box);
    ReductionOptions options = of({"x_min"});
    options.modes = 3 * (c.box.n[0] * (c.box.n[1] + 1) * (c.box.n[2] + 1));
    const Superelement all = reduced(mesh, options, MassKind::lumped);
    for (const Index modes : c.modes) {
      options.modes = modes;
      const Superelement s = reduced(mesh, options, MassKind::lumped);
      const Superelement::Accuracy& a = *s.accuracy;
      ASSERT_GE(a.eigenvalue_error.size(), modes == 12 ? 6 : 10) << c.box.size[0] << " " << modes;
      for (Index j = 0; j < std::min<Index>(a.eigenvalue_error.size(), 10); ++j) {
        const double truth = 1 - std::pow(all.omega(6 + j) / s.omega(6 + j), 2);
        EXPECT_GT(a.eigenvalue_error(j), 0.97 * truth - 1e-7)
            << c.box.size[0] << " " << modes << " " << j;
        // from above, the nearer the first held mode that is missing
        if (a.frequency_hz(j) > 0.8 * a.complete_hz) continue;
        EXPECT_LT(a.eigenvalue_error(j), 1.4 * truth + 1e-7)
            << c.box.size[0] << " " << modes << " " << j;
      }
    }
  }
}

// Residual vectors are no eigenvectors: what drives the modes that are missing is also their own
// inertia.
TEST_P(Accuracy, EstimatedErrorsWithResidualVectorsAreTheTrueOnes) {
  const Mesh mesh = block();
  const Full f = full(mesh, {"x_max"}, GetParam());
  Index compared = 0;
  for (const Index modes : {4, 12, 40}) {
    ReductionOptions options = of({"x_max"});
    options.modes = modes;
    options.loads = {"x_min", "y_max"};
    const Superelement s = reduced(mesh, options, GetParam());
    ASSERT_EQ(s.n_residual, 6);
    const Superelement::Accuracy& a = *s.accuracy;
    compared += a.eigenvalue_error.size();
    for (Index j = 0; j < a.eigenvalue_error.size(); ++j) {
      const double truth = 1 - f.eigenvalues(6 + j) / (s.omega(6 + j) * s.omega(6 + j));
      EXPECT_GT(a.eigenvalue_error(j), (j < 10 ? 0.99 : 0.95) * truth) << modes << " " << j;
      // 1.48 and 1.62 are the largest
      EXPECT_LT(a.eigenvalue_error(j), (modes > 4 ? 1.5 : 1.7) * truth) << modes << " " << j;
    }
  }
  EXPECT_GE(compared, 10);
}

// Bases that are made of Craig-Bampton's form: what they add to its errors is in their estimates.
TEST_P(Accuracy, EstimatedErrorsOfOtherBasesAreTheTrueOnes) {
  const Mesh mesh = block();
  const Full f = full(mesh, {"x_max"}, GetParam());
  Vector3 rho = Vector3::Zero();
  const auto compare = [&](const ReductionOptions& options, const char* what) {
    const Superelement s = reduced(mesh, options, GetParam());
    const Superelement::Accuracy& a = s.accuracy.value();
    EXPECT_LT((a.rho_res - rho).norm(), 1e-9) << what;
    const auto truth = [&](Index j) { return 1 - f.eigenvalues(6 + j) / s.eigenvalues(6 + j); };
    double worst = 0;
    for (Index j = 0; j < 10; ++j) worst = std::max(worst, std::abs(truth(j)));
    EXPECT_NEAR(a.worst_of_ten.value(), 1.18 * worst, 0.21 * worst) << what;
    ASSERT_GT(a.frequency_hz.size(), 0) << what;
    for (Index j = 0; j < a.frequency_hz.size(); ++j) {
      EXPECT_NEAR(a.frequency_hz(j), std::sqrt(s.eigenvalues(6 + j)) / (2 * std::numbers::pi),
                  1e-9 * a.frequency_hz(j));
      EXPECT_GE(a.eigenvalue_error(j), (j < 10 ? 0.97 : 0.85) * std::abs(truth(j)) - 1e-9)
          << what << " " << j;
      EXPECT_TRUE(a.frequency_hz(j) > a.covered_hz || 1 - std::sqrt(1 - truth(j)) <= 0.0101)
          << what << " " << j;
    }
    EXPECT_TRUE(a.surfaces.empty()) << what;
  };
  ReductionOptions options = of({"x_max"});
  options.modes = 60;
  rho = reduced(mesh, options, GetParam()).accuracy->rho_res;
  options.basis = Basis::characteristic;
  options.characteristic.modes = 3;
  compare(options, "3 shapes");
  options.characteristic.modes = 15;
  compare(options, "15 shapes");
}

TEST_P(Accuracy, FreeModesAreExactAndNoneIsMissing) {
  const Mesh mesh = block();
  const Full f = full(mesh, {"x_max"}, GetParam());
  for (const MasslessModes modes : {MasslessModes::free, MasslessModes::tapered}) {
    ReductionOptions options = of({"x_max"});
    options.basis = Basis::massless;
    options.massless_modes = modes;
    options.modes = 20;
    const Superelement s = reduced(mesh, options, GetParam());
    const Superelement::Accuracy& a = s.accuracy.value();
    const auto hz = [&](Index j) {
      return std::sqrt(f.eigenvalues(6 + j)) / (2 * std::numbers::pi);
    };
    ASSERT_EQ(a.frequency_hz.size(), 20);
    for (Index j = 0; j < 20; ++j) EXPECT_NEAR(a.frequency_hz(j), hz(j), 1e-9 * hz(j)) << j;
    EXPECT_EQ(a.eigenvalue_error.maxCoeff(), 0);
    EXPECT_NEAR(a.covered_hz, hz(19), 1e-9 * hz(19));
    EXPECT_NEAR(a.complete_hz, hz(20), 1e-6 * hz(20));
    EXPECT_EQ(a.interface_share.size(), modes == MasslessModes::free ? 0 : 20);
    for (Index j = 1; j < a.interface_share.size(); ++j)
      EXPECT_LE(a.interface_share(j), a.interface_share(j - 1)) << j;
  }
}

// Few modes or none, some of them picked, and as many frequencies as are said to be right to 1 %.
TEST_P(Accuracy, WhatIsCoveredIsRight) {
  const Mesh mesh = block();
  for (const auto& sets : {std::vector<std::string>{"x_max"}, {"x_min", "z_max"}}) {
    const Full f = full(mesh, sets, GetParam());
    double before = 0;
    for (const Index modes : {0, 5, 12, 30, 60}) {
      for (const Pick pick : {Pick::frequency, Pick::participation}) {
        ReductionOptions options = of(sets);
        options.modes = modes;
        options.pick = pick;
        const Superelement s = reduced(mesh, options, GetParam());
        const Superelement::Accuracy& a = *s.accuracy;
        EXPECT_GT(a.complete_hz, 0);
        for (Index j = 0; j < a.frequency_hz.size(); ++j) {
          const double truth = 1 - f.eigenvalues(6 + j) / (s.omega(6 + j) * s.omega(6 + j));
          EXPECT_GE(a.eigenvalue_error(j), (j < 10 ? 0.95 : 0.85) * truth - 1e-12)
              << modes << " " << j;
          EXPECT_LT(a.eigenvalue_error(j), 1);
          if (a.frequency_hz(j) <= a.covered_hz) {
            EXPECT_LE(1 - std::sqrt(1 - truth), 0.0101) << modes << " " << j;
          }
        }
        if (pick != Pick::frequency) continue;
        EXPECT_GE(a.covered_hz, before);
        before = a.covered_hz;
      }
    }
    EXPECT_GT(before, 0);
  }
}

// The motion under pressure has no rigid part that depends on where the interface's nodes are.
TEST_P(Accuracy, PressureLeavesTheSameOutOnAGradedMesh) {
  const auto left = [&](double grading) {
    Mesh mesh = box_mesh({{5, 6, 6}, {2, 2, 2}, {0, 0, 0}, 0});
    for (Index i = 0; i < mesh.coordinates.rows(); ++i) {
      double& y = mesh.coordinates(i, 1);
      // elements at one end are (1 + grading) / (1 - grading) times those at the other
      y += grading * y * (2 - y) / 2;
    }
    ReductionOptions options = of({"x_max"});
    options.modes = 12;
    return reduced(mesh, options, GetParam()).accuracy->surfaces.at("x_max").strain_left_out;
  };
  const double even = left(0);
  EXPECT_NEAR(left(0.5), even, 0.1 * even);
}

TEST_P(Accuracy, StrainLeftOutIsThatOfAnAcceleratedInterface) {
  const Mesh mesh = block();
  const Full f = full(mesh, {"x_max"}, GetParam());
  ReductionOptions options = of({"x_max"});
  options.modes = 12;
  options.recovery = true;
  const Superelement of_basis = reduced(mesh, options, GetParam());
  options.exact_modes = true;
  const Superelement s = reduced(mesh, options, GetParam());
  const Matrix& Phi = s.recovery.at(0).Phi;
  const Cholesky K_II{Matrix(f.p.K_II)};
  const Matrix Y =
      f.p.M_IC * Matrix(reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c())) +
      f.p.M_II * s.recovery.at(0).Psi *
          reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c());
  Vector direction(6);
  direction << 0.3, -1, 0.2, 0.1, 0.4, -0.7;
  double most = 0;
  for (Index i = 0; i <= 6; ++i) {
    const Vector y = i < 6 ? Vector(Y.col(i)) : Vector(Y * direction);
    // Constant acceleration: u = K_II^-1 y, with modes Phi Lambda^-1 Phi^T y; energies y^T u / 2
    const double whole = y.dot(K_II.solve(y)),
                 caught = (Phi.transpose() * y).cwiseAbs2().dot(s.eigenvalues.cwiseInverse());
    const double left = 1 - caught / whole;
    if (i < 6) {
      EXPECT_NEAR(s.accuracy->strain_left_out(i), left, 1e-9) << i;
      EXPECT_NEAR(of_basis.accuracy->strain_left_out(i), left, 1e-4 * left) << i;
    }
    most = std::max(most, left);
  }
  EXPECT_GE(s.accuracy->largest_left_out, most - 1e-9);
  EXPECT_LT(s.accuracy->largest_left_out, 1);
}

TEST_P(Accuracy, FlatImpactLosesWhatStoppingTheFaceTakes) {
  const Mesh mesh = box_mesh({{5, 3, 3}, {5, 3, 3}, {0, 0, 0}, 0});
  ReductionOptions options = of({"surface"});
  options.modes = 15;
  const Superelement s = reduced(mesh, options, GetParam());
  const Matrix M = reduced_mass(s);
  const Vector v = reduced_rigid_modes(s, s.rigid_body.center).col(0);  // along x
  for (const Surface& surface : s.surfaces) {
    if (surface.name != "x_max" && surface.name != "x_min") continue;
    // v+ = v - M^-1 G^T (G M^-1 G^T)^-1 G v on all coordinates
    const std::vector<Index> nodes = surface_nodes(surface);
    Matrix G = Matrix::Zero(static_cast<Index>(nodes.size()), s.n());
    for (Index i = 0; i < s.c(); ++i)
      for (std::size_t j = 0; j < nodes.size(); ++j)
        if (s.dof_node[i] == nodes[j] && s.dof_component[i] == 0)
          G(static_cast<Index>(j), s.k() + i) = 1;
    const Matrix X = Cholesky(M).solve(G.transpose());
    const Vector after = v - X * Cholesky(Matrix(G * X)).solve(G * v);
    const double lost = 1 - after.dot(M * after) / v.dot(M * v);
    EXPECT_NEAR(s.accuracy->surfaces.at(surface.name).impact, lost, 1e-9);
    EXPECT_LT(lost, s.accuracy->rho_res(0));  // all of the surface stopped
  }
  EXPECT_EQ(s.accuracy->surfaces.count("surface"), 0U);  // has no normal
}

TEST_P(Accuracy, AToleranceBoundsWhatItSays) {
  const Mesh mesh = block();
  for (const auto& sets : {std::vector<std::string>{"x_max"}, {"x_min", "z_max"}}) {
    const Full f = full(mesh, sets, GetParam());
    Index before = 0;
    for (const double tolerance : {0.1, 1e-2, 1e-3}) {
      ReductionOptions options = of(sets);
      options.tolerance = tolerance;
      ReductionFigures figures;
      const Superelement s = reduced(mesh, options, GetParam(), &figures);
      EXPECT_GT(s.k(), before) << tolerance;
      EXPECT_LT(s.k(), f.p.n_interior()) << tolerance;
      EXPECT_LE(s.k(), figures.n_candidates);
      EXPECT_LE(s.accuracy->largest_left_out, tolerance * (1 + 1e-9));
      EXPECT_EQ(s.accuracy->tolerance, tolerance);
      for (Index j = 6; j < 16; ++j)
        EXPECT_LE(1 - f.eigenvalues(j) / (s.omega(j) * s.omega(j)), tolerance) << j;
      before = s.k();
    }
  }
}

// Blocks whose eleventh free mode is poor and near the tenth, which it mixes with: where each
// mode's error is estimated by itself the tenth was up to 2.85 times the tolerance off.
TEST(ModeTolerance, BoundsAModeThatMixesWithAPoorOne) {
  struct Case {
    std::array<Index, 3> n;
    MassKind mass;
    double tolerance;
  };
  for (const Case& c :
       {Case{{8, 4, 4}, MassKind::lumped, 3e-3}, Case{{8, 4, 5}, MassKind::consistent, 3e-3}}) {
    const Mesh mesh = box_mesh({c.n, {4, 2, 3}, {0, 0, 0}, 0});
    ReductionOptions options = of({"x_max"});
    options.tolerance = c.tolerance;
    const Superelement s = reduced(mesh, options, c.mass);
    const Full f = full(mesh, {"x_max"}, c.mass);
    const Vector lambda = s.omega.segment(6, 10).cwiseAbs2();
    const Vector truth = 1 - f.eigenvalues.segment(6, 10).array() / lambda.array();
    EXPECT_LE(truth.maxCoeff(), c.tolerance);
    EXPECT_GT(truth.maxCoeff(), 0.5 * c.tolerance);  // no more modes than it takes
    EXPECT_LE(s.accuracy->eigenvalue_error.head(10).maxCoeff(), c.tolerance);
  }
}

// The interface gets a constant acceleration at once: at any time the strain energy of what is
// missing is at most four times the share that the tolerance allows of the static deflection's, as
// 1 - cos is at most 2.
TEST_P(Accuracy, AToleranceBoundsAStepOfAcceleration) {
  const Mesh mesh = block();
  const Full f = full(mesh, {"x_max"}, GetParam());
  ReductionOptions options = of({"x_max"});
  options.tolerance = 1e-2;
  options.recovery = true;
  const Superelement s = reduced(mesh, options, GetParam());
  const Eigenpairs held = dense_eigenpairs(Matrix(f.p.K_II), Matrix(f.p.M_II), f.p.n_interior());
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c());
  const Matrix Y = f.p.M_IC * R + f.p.M_II * s.recovery.at(0).Psi * R;
  for (Index i = 0; i < 6; ++i) {
    const Vector a = held.Phi.transpose() * Y.col(i), b = s.M_kc * R.col(i);
    const double still = a.cwiseAbs2().dot(held.lambda.cwiseInverse());
    for (double t = 0.05; t < 20; t *= 1.3) {
      const auto swing = [&](double lambda) {
        return (1 - std::cos(std::sqrt(lambda) * t)) / lambda;
      };
      const Vector all = held.Phi * a.cwiseProduct(held.lambda.unaryExpr(swing));
      const Vector few = s.recovery.at(0).Phi * b.cwiseProduct(s.eigenvalues.unaryExpr(swing));
      EXPECT_LE((all - few).dot(f.p.K_II * (all - few)), 4 * *options.tolerance * still)
          << i << " " << t;
    }
  }
}

TEST(ModeTolerance, MoreModesAreThoseOfOneSolve) {
  const Mesh mesh = box_mesh({{8, 7, 6}, {8, 7, 6}, {0, 0, 0}, 0.03});
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
  const Partition p = partition(model, interface_nodes(mesh, model, {"x_max"}));
  const SparseCholesky factor(p.K_II);
  Report report("test", Verbosity::quiet);
  const FixedInterfaceModes few = fixed_interface_modes(p, factor, 20, report);
  const FixedInterfaceModes more = more_modes(p, factor, few, 55, report),
                            all = fixed_interface_modes(p, factor, 55, report);
  ASSERT_EQ(more.lambda.size(), 55);
  EXPECT_EQ(Matrix(more.Phi.leftCols(20)), few.Phi);  // kept, not found again
  EXPECT_TRUE(more.proven);
  EXPECT_LT((more.lambda - all.lambda).cwiseQuotient(all.lambda).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LT(
      (more.Phi.transpose() * p.M_II * more.Phi - Matrix::Identity(55, 55)).cwiseAbs().maxCoeff(),
      1e-11);
  const Matrix residual = p.K_II * more.Phi - p.M_II * more.Phi * more.lambda.asDiagonal();
  EXPECT_LT(residual.colwise().norm().maxCoeff(), 1e-8 * all.lambda(54));
  EXPECT_EQ(more_modes(p, factor, few, 15, report).lambda.size(), 20);
}

TEST(ModeTolerance, FewerModesThanTheLowestThatDoAsWell) {
  const Mesh mesh = box_mesh({{10, 4, 4}, {10, 4, 4}, {0, 0, 0}, 0});
  ReductionOptions options = of({"x_max"});
  options.tolerance = 1e-2;
  ReductionFigures figures;
  const Superelement picked = reduced(mesh, options, MassKind::lumped, &figures);
  options.tolerance.reset();
  options.modes = picked.k();
  const Superelement lowest = reduced(mesh, options, MassKind::lumped);
  const auto largest = [](const Superelement& s) {
    return std::max(s.accuracy->largest_left_out, s.accuracy->eigenvalue_error.head(10).maxCoeff());
  };
  EXPECT_LE(largest(picked), 1e-2);
  EXPECT_GT(largest(lowest), largest(picked));
  // A square section bends both ways alike
  EXPECT_NEAR(picked.accuracy->rho_res(1), picked.accuracy->rho_res(2), 1e-6);
}

TEST(ModeTolerance, NothingInsideNeedsNoModes) {
  const Mesh mesh = box_mesh({{1, 1, 1}, {1, 1, 1}, {0, 0, 0}, 0});
  ReductionOptions options = of({"surface"});
  options.tolerance = 1e-2;
  const Superelement s = reduced(mesh, options, MassKind::lumped);
  EXPECT_EQ(s.k(), 0);
  EXPECT_EQ(s.accuracy->largest_left_out, 0);
}

TEST(ModeTolerance, RefusesWhatIsNoShareAndTwoWishes) {
  const Mesh mesh = box_mesh({{2, 2, 2}, {1, 1, 1}, {0, 0, 0}, 0});
  for (const double wrong : {0.0, 1.0, -1.0}) {
    ReductionOptions options = of({"x_max"});
    options.tolerance = wrong;
    EXPECT_THROW(reduced(mesh, options, MassKind::lumped), InputError) << wrong;
  }
  ReductionOptions two = of({"x_max"});
  two.tolerance = 0.1;
  two.modes = 3;
  EXPECT_THROW(reduced(mesh, two, MassKind::lumped), InputError);
}
}  // namespace
}  // namespace cbr::test::accuracy_test
