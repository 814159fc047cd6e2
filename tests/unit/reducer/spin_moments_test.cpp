// SPDX-License-Identifier: GPL-3.0-or-later
// Moments of the coordinates: of strains that the interface has, and of rigid motions, from the
// inertia alone.
#include "reducer/modes/interior_loads.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <map>
#include <vector>

#include "common/app/report.hpp"
#include "common/linalg/blas_threads.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test::spin_moments_test {
namespace {

class SpinMoments : public testing::TestWithParam<MassKind> {};

Superelement reduced(MassKind mass) {
  set_threads(1);  // small matrices, and other tests run beside this one
  const Mesh mesh = box_mesh({{4, 3, 3}, {4, 2, 3}, {1, 2, 3}, 0.05});
  ReductionOptions options;
  options.interface_sets = {"surface"};
  options.modes = 5;
  Report report("test", Verbosity::quiet);
  return reduce(mesh, properties(mesh, {1000, 0.3, 2}), mass, options, {}, report);
}

// S of a displacement u = A x of the interface, which the interior follows, as a matrix.
Matrix3 moments_of(const Superelement& s, const Matrix3& A) {
  Vector q = Vector::Zero(s.n());
  for (Index i = 0; i < s.c(); ++i) {
    const Vector3 x = s.coordinates.row(s.dof_node[i]).transpose() - s.rigid_body.center;
    q[s.k() + i] = (A * x)[s.dof_component[i]];
  }
  const Vector S = s.spin_moments.transpose() * q;
  Matrix3 all;
  all << S[0], S[3], S[5], S[3], S[1], S[4], S[5], S[4], S[2];
  return all;
}

// int rho x (A x)^T = P A^T, P = tr J / 2 - J.
TEST_P(SpinMoments, OfLinearMotionsAreThoseOfTheInertia) {
  const Superelement s = reduced(GetParam());
  const Matrix3& J = s.rigid_body.inertia;
  const Matrix3 P = 0.5 * J.trace() * Matrix3::Identity() - J;
  Matrix3 strain, turn;
  strain << 0.3, 0.1, -0.4, 0.1, 0.7, 0.2, -0.4, 0.2, -0.5;
  turn << 0, -1, 0.5, 1, 0, -0.2, -0.5, 0.2, 0;
  for (const Matrix3& A : {strain, turn, Matrix3(strain + turn)}) {
    const Matrix3 expected = 0.5 * (P * A.transpose() + A * P);
    EXPECT_LT((moments_of(s, A) - expected).norm(), 1e-12 * P.norm());
  }
}

// Of each mode's displacements at all nodes, by the full component's mass.
TEST_P(SpinMoments, CouplingsAreThoseOfTheFullComponent) {
  set_threads(1);
  const Mesh mesh = box_mesh({{4, 3, 3}, {4, 2, 3}, {1, 2, 3}, 0.05});
  const std::vector<BlockProperties> material = properties(mesh, {1000, 0.3, 2});
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = 5;
  options.recovery = true;
  Report report("test", Verbosity::quiet);
  const Superelement s = reduce(mesh, material, GetParam(), options, {}, report);
  const FiniteElementModel model = assemble(mesh, material, GetParam());
  constexpr Index n_rigid = 6, m = 8;
  ASSERT_GT(s.n(), n_rigid + m);
  ASSERT_EQ(s.spin_couplings.rows(), 3 * m);
  // Displacements in the order of the model's nodes
  const Matrix V = s.V.middleCols(n_rigid, m);
  const auto& recovery = s.recovery[0];
  const Matrix inside = recovery.Psi * V.bottomRows(s.c()) + recovery.Phi * V.topRows(s.k());
  std::map<Index, Matrix> of_node;
  for (std::size_t i = 0; i < s.node_ids.size(); ++i)
    of_node[s.node_ids[i]] = V.middleRows(s.k() + 3 * static_cast<Index>(i), 3);
  for (std::size_t i = 0; i < recovery.node_ids.size(); ++i)
    of_node[recovery.node_ids[i]] = inside.middleRows(3 * static_cast<Index>(i), 3);
  Matrix X(model.M.rows(), m);
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    X.middleRows(3 * static_cast<Index>(i), 3) = of_node.at(mesh.node_ids[model.nodes[i]]);
  const auto only = [](const Matrix& of, Index from, Index to) {
    Matrix Y = Matrix::Zero(of.rows(), of.cols());
    for (Index i = 0; i < of.rows(); i += 3) Y.row(i + to) = of.row(i + from);
    return Y;
  };
  for (Index a = 0; a < 3; ++a)
    for (Index b = 0; b < 3; ++b) {
      const Matrix expected = X.transpose() * (model.M * only(X, b, a));
      Matrix found(m, m);
      for (Index i = 0; i < m; ++i)
        for (Index j = 0; j < m; ++j) found(i, j) = s.spin_couplings(3 * i + a, 3 * j + b);
      EXPECT_LT((found - expected).norm(), 1e-11) << a << " " << b;
      EXPECT_GT(expected.norm(), 0.1) << a << " " << b;
    }
}

// A run of another form than the stored one could not tell whose they are.
TEST(SpinCouplings, AreOfTheStoredFormAndOfWhatTurns) {
  set_threads(1);
  const Mesh mesh = box_mesh({{2, 2, 2}, {2, 2, 2}, {0, 0, 0}, 0.05});
  Report report("test", Verbosity::quiet);
  const auto reduced = [&](Basis basis, bool is_diagonal_read) {
    ReductionOptions options;
    options.interface_sets = {"x_max"};
    options.modes = 5;
    options.basis = basis;
    ReduceSettings settings;
    settings.is_diagonal_read = is_diagonal_read;
    return reduce(mesh, properties(mesh, {1000, 0.3, 2}), MassKind::lumped, options, settings,
                  report);
  };
  EXPECT_GT(reduced(Basis::craig_bampton, true).spin_couplings.size(), 0);
  EXPECT_EQ(reduced(Basis::craig_bampton, false).spin_couplings.size(), 0);
  EXPECT_EQ(reduced(Basis::massless, true).spin_couplings.size(), 0);
}

INSTANTIATE_TEST_SUITE_P(Masses, SpinMoments,
                         testing::Values(MassKind::lumped, MassKind::consistent));

}  // namespace
}  // namespace cbr::test::spin_moments_test
