// SPDX-License-Identifier: GPL-3.0-or-later
// Constant membrane strain and constant curvature on distorted meshes anywhere in space.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/shell_mesh.hpp"

namespace cbr::test::shell_patch_test {
namespace {

constexpr double nu = 0.3, E = 7e10;
constexpr Index n = 5;

// Inner nodes moved at random; in a plane of its own when tilted.
struct Patch {
  ShellMesh mesh;
  Points flat;  // before tilting
  Matrix3 Q = Matrix3::Identity();
};

Patch patch(Faces kind, bool tilted) {
  Patch p;
  unsigned state = 5;
  const auto random = [&state] {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / (1 << 24) - 0.5;
  };
  p.mesh = shell_grid(kind, n, n, [&](double x, double y) {
    const bool inner = x > 0.01 && x < 0.99 && y > 0.01 && y < 0.99;
    const double dx = inner ? 0.11 * random() : 0, dy = inner ? 0.11 * random() : 0;
    return Vector3(1.3 * (x + dx), y + dy, 0);
  });
  p.flat = p.mesh.X;
  if (tilted) p.Q = Eigen::AngleAxisd(1.1, Vector3(1, -2, 0.7).normalized()).toRotationMatrix();
  p.mesh.X = p.flat * p.Q.transpose();
  return p;
}

// Per node (u, theta) in the patch's own axes -> dofs in the axes of space.
Vector turned(const Patch& p,
              const std::function<Eigen::Matrix<double, 6, 1>(double, double)>& field) {
  const Index m = p.flat.rows();
  Vector u(6 * m);
  for (Index i = 0; i < m; ++i) {
    const Eigen::Matrix<double, 6, 1> local = field(p.flat(i, 0), p.flat(i, 1));
    u.segment<3>(3 * i) = p.Q * local.head<3>();
    u.segment<3>(3 * m + 3 * i) = p.Q * local.tail<3>();
  }
  return u;
}

// Boundary nodes take `exact`; what do the inner ones?
Vector solved(const Patch& p, const ShellModel& shells, const Vector& exact) {
  const Index m = p.flat.rows();
  std::map<Index, double> prescribed;
  for (Index i = 0; i < m; ++i) {
    const Index row = i / (n + 1), column = i % (n + 1);
    if (row > 0 && row < n && column > 0 && column < n) continue;
    for (int c = 0; c < 6; ++c) prescribed[shell_dof(m, i, c)] = exact(shell_dof(m, i, c));
  }
  return solve_shells(shells.K, Vector::Zero(6 * m), prescribed);
}

class ShellPatch : public testing::TestWithParam<std::tuple<Faces, bool>> {};

TEST_P(ShellPatch, ConstantMembraneStrain) {
  const Patch p = patch(std::get<0>(GetParam()), std::get<1>(GetParam()));
  // u,x v,y; u,y = xy - spin, v,x = xy + spin
  const double xx = 1e-3, yy = -4e-4, xy = 3e-4, spin = 2e-4, t = 0.01;
  const Vector exact = turned(p, [&](double x, double y) {
    Eigen::Matrix<double, 6, 1> u;
    u << xx * x + (xy - spin) * y, (xy + spin) * x + yy * y, 0, 0, 0, spin;
    return u;
  });
  const ShellModel shells = assemble_shells(p.mesh.faces, p.mesh.X, {{E, nu, 1}, t});
  EXPECT_LE((solved(p, shells, exact) - exact).cwiseAbs().maxCoeff(),
            1e-12 * exact.cwiseAbs().maxCoeff());
  const double energy =
      E * t / (1 - nu * nu) * (xx * xx + yy * yy + 2 * nu * xx * yy + 2 * (1 - nu) * xy * xy) * 1.3;
  EXPECT_NEAR(exact.dot(shells.K * exact) / energy, 1, 1e-12);
}

TEST_P(ShellPatch, ConstantCurvature) {
  const auto [kind, tilted] = GetParam();
  const Patch p = patch(kind, tilted);
  const double a = 1e-2, b = -7e-3, c = 5e-3;  // w = a x^2/2 + b y^2/2 + c x y
  const Vector exact = turned(p, [&](double x, double y) {
    Eigen::Matrix<double, 6, 1> u;
    u << 0, 0, a * x * x / 2 + b * y * y / 2 + c * x * y, c * x + b * y, -a * x - c * y, 0;
    return u;
  });
  // Off the axes, round-off of the membrane is what limits thin shells.
  for (const double t : {1.0, 0.03, 1e-3, 1e-7, 1e-12}) {
    if (tilted && t < 1e-2) continue;
    const ShellModel shells = assemble_shells(p.mesh.faces, p.mesh.X, {{E, nu, 1}, t});
    EXPECT_LE((solved(p, shells, exact) - exact).cwiseAbs().maxCoeff(),
              1e-10 * exact.cwiseAbs().maxCoeff())
        << t;
    const double energy = E * t * t * t / 12 / (1 - nu * nu) *
                          (a * a + b * b + 2 * nu * a * b + 2 * (1 - nu) * c * c) * 1.3;
    EXPECT_NEAR(exact.dot(shells.K * exact) / energy, 1, 1e-10) << t;
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, ShellPatch,
                         testing::Combine(testing::Values(Faces::quads, Faces::triangles,
                                                          Faces::mixed),
                                          testing::Bool()));

}  // namespace
}  // namespace cbr::test::shell_patch_test
