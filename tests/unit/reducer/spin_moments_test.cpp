// SPDX-License-Identifier: GPL-3.0-or-later
// Moments of the coordinates: of strains that the interface has, and of rigid motions, from the
// inertia alone.
#include "reducer/modes/spin_moments.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

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

INSTANTIATE_TEST_SUITE_P(Masses, SpinMoments,
                         testing::Values(MassKind::lumped, MassKind::consistent));

}  // namespace
}  // namespace cbr::test::spin_moments_test
