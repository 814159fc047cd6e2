// SPDX-License-Identifier: GPL-3.0-or-later
// Plates, a strip, curved shells and a box against closed forms and the benchmarks of the
// literature, with orders of convergence.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/linalg/eigen/eigenpairs.hpp"
#include "tests/support/shell_mesh.hpp"

namespace cbr::test::shell_convergence_test {
namespace {

using std::numbers::pi;
using Prescribed = std::map<Index, double>;

double slope(double coarse, double fine) { return std::log2(std::abs(coarse / fine)); }

// A unit square in the x-y plane; distorted: inner nodes follow a smooth map that keeps the middle.
ShellMesh square(Faces kind, Index n) {
  return shell_grid(kind, n, n, [](double x, double y) {
    const double s = 0.05 * std::sin(2 * pi * x) * std::sin(2 * pi * y);
    return Vector3(x + s, y - s, 0);
  });
}

bool at(double x, double value) { return std::abs(x - value) < 1e-9; }

// Membrane dofs held; w (and rotations) of the edges by kind of support.
Prescribed plate_support(const ShellMesh& mesh, bool clamped) {
  Prescribed fixed;
  const Index m = mesh.X.rows();
  for (Index i = 0; i < m; ++i) {
    for (const int c : {0, 1, 5}) fixed[shell_dof(m, i, c)] = 0;
    const bool x_edge = at(mesh.X(i, 0), 0) || at(mesh.X(i, 0), 1),
               y_edge = at(mesh.X(i, 1), 0) || at(mesh.X(i, 1), 1);
    if (x_edge || y_edge) fixed[shell_dof(m, i, 2)] = 0;
    if (x_edge || (clamped && y_edge)) fixed[shell_dof(m, i, 3)] = 0;  // theta_x = w,y
    if (y_edge || (clamped && x_edge)) fixed[shell_dof(m, i, 4)] = 0;
  }
  return fixed;
}

constexpr double nu = 0.3, E = 2e11, thin = 1e-4;
double rigidity(double t) { return E * t * t * t / (12 * (1 - nu * nu)); }

// Deflection of the middle over q a^4 / D, or over P a^2 / D.
double plate_coefficient(Faces kind, Index n, bool clamped, bool central_force) {
  const ShellMesh mesh = square(kind, n);
  // mass: area shares
  const ShellModel shells = assemble_shells(mesh.faces, mesh.X, {{E, nu, 1 / thin}, thin});
  const Index middle = (n / 2) * (n + 1) + n / 2;
  Vector f = Vector::Zero(shells.K.rows());
  for (Index i = 0; i < mesh.X.rows(); ++i)
    f(3 * i + 2) = central_force ? (i == middle ? 1 : 0) : shells.mass(i);
  return solve_shells(shells.K, f, plate_support(mesh, clamped))(3 * middle + 2) * rigidity(thin);
}

// Navier's series for the middle of a simply supported unit square.
double navier(bool central_force) {
  double sum = 0;
  for (int m = 1; m < 400; m += 2)
    for (int n = 1; n < 400; n += 2) {
      const double k = std::pow(pi, 4) * std::pow(m * m + n * n, 2);
      sum += central_force ? 4 / k : ((m + n) / 2 % 2 == 1 ? 1 : -1) * 16 / (pi * pi * m * n) / k;
    }
  return sum;
}

struct PlateCase {
  bool clamped, central_force;
  double exact;
};

class Plate : public testing::TestWithParam<Faces> {};

// Clamped: Taylor, Govindjee 2004 (doi 10.1002/cnm.652); to three digits these are Timoshenko's
// 0.00406, 0.0116, 0.00126, 0.0056.
TEST_P(Plate, MiddleDeflection) {
  for (const PlateCase& c :
       {PlateCase{false, false, navier(false)}, PlateCase{false, true, navier(true)},
        PlateCase{true, false, 0.00126532}, PlateCase{true, true, 0.0056120}}) {
    const double coarse =
        plate_coefficient(GetParam(), 12, c.clamped, c.central_force) / c.exact - 1;
    const double fine = plate_coefficient(GetParam(), 24, c.clamped, c.central_force) / c.exact - 1;
    RecordProperty("slope", std::to_string(slope(coarse, fine)));
    EXPECT_LE(std::abs(fine), 0.01);
    // Under a force the moments are singular: h^2 log h.
    EXPECT_GE(slope(coarse, fine), c.central_force ? 1.5 : 1.8);
  }
}

// omega_mn = pi^2 (m^2 + n^2) sqrt(D / (rho t)) / a^2, lumped mass and rotary inertia.
TEST_P(Plate, SimplySupportedFrequencies) {
  const auto errors = [&](Index n) {
    const ShellMesh mesh = square(GetParam(), n);
    const ShellModel shells = assemble_shells(mesh.faces, mesh.X, {{E, nu, 7850}, thin});
    const Prescribed fixed = plate_support(mesh, false);
    std::vector<Index> free;
    for (Index i = 0; i < shells.K.rows(); ++i)
      if (!fixed.contains(i)) free.push_back(i);
    std::vector<Eigen::Triplet<double, Index>> mass;
    for (std::size_t i = 0; i < free.size(); ++i) {
      const Index dof = free[i], half = shells.K.rows() / 2, row = static_cast<Index>(i);
      mass.emplace_back(row, row,
                        dof < half ? shells.mass(dof / 3) : shells.rotary((dof - half) / 3));
    }
    const SparseMatrix K = submatrix(shells.K, free);
    SparseMatrix M(K.rows(), K.cols());
    M.setFromTriplets(mass.begin(), mass.end());
    const auto pairs = sparse_eigenpairs(K, M, SparseCholesky(K), 0, 6);
    EXPECT_TRUE(pairs.converged);
    const double unit = pi * pi * std::sqrt(rigidity(thin) / (7850 * thin));
    Vector e = pairs.lambda.head(4).cwiseSqrt() / unit;
    return Vector(e.array() / Eigen::Array4d(2, 5, 5, 8) - 1);
  };
  const Vector coarse = errors(10), fine = errors(20);
  for (Index k = 0; k < 4; ++k) {
    EXPECT_LE(std::abs(fine(k)), 0.02);
    EXPECT_GE(slope(coarse(k), fine(k)), 1.7);
  }
}

// Tip of a cantilever strip under a force: P L^3 / (3 E I) + P L / (kappa G A).
TEST_P(Plate, CantileverStrip) {
  const auto error = [&](Index n, double t) {
    const double L = 1, b = 0.1;
    const ShellMesh mesh =
        shell_grid(GetParam(), n, 2, [&](double x, double y) { return Vector3(L * x, b * y, 0); });
    const ShellModel shells = assemble_shells(mesh.faces, mesh.X, {{E, 0, 1}, t});
    const Index m = mesh.X.rows();
    Prescribed fixed;
    Vector f = Vector::Zero(6 * m);
    for (Index i = 0; i < m; ++i) {
      if (at(mesh.X(i, 0), 0))
        for (int c = 0; c < 6; ++c) fixed[shell_dof(m, i, c)] = 0;
      if (at(mesh.X(i, 0), L)) f(3 * i + 2) = at(mesh.X(i, 1), b / 2) ? 0.5 : 0.25;
    }
    const double exact = 4 * L * L * L / (E * b * t * t * t) + L / (5.0 / 6 * E / 2 * b * t);
    return solve_shells(shells.K, f, fixed)(3 * n + 2) / exact - 1;
  };
  for (const double t : {0.2, 1e-3, 1e-6}) {
    const double coarse = error(8, t), fine = error(16, t);
    if (GetParam() == Faces::quads)
      EXPECT_LE(std::abs(coarse), 1e-8) << t;
    else
      EXPECT_LE(std::abs(fine), 5e-3) << t;
  }
}

// Scordelis and Lo's roof: vertical displacement of the middle of the free edge; 0.3024 is the
// usual reference (MacNeal, Harder 1985, doi 10.1016/0168-874X(85)90003-4), flat and deep-shell
// elements tend to 0.3006.
TEST_P(Plate, ScordelisLoRoof) {
  const auto deflection = [&](Index n) {
    const double R = 25, half = 25, angle = 40 * pi / 180;
    const ShellMesh mesh = shell_grid(GetParam(), n, n, [&](double x, double y) {
      return Vector3(R * std::sin(angle * x), half * y, R * std::cos(angle * x));
    });
    // mass: area shares
    const ShellModel shells = assemble_shells(mesh.faces, mesh.X, {{4.32e8, 0, 4}, 0.25});
    const Index m = mesh.X.rows();
    Prescribed fixed;
    Vector f = Vector::Zero(6 * m);
    for (Index i = 0; i < m; ++i) {
      f(3 * i + 2) = -90 * shells.mass(i);
      if (at(mesh.X(i, 0), 0))
        for (const int c : {0, 4, 5}) fixed[shell_dof(m, i, c)] = 0;  // symmetry
      if (at(mesh.X(i, 1), 0))
        for (const int c : {1, 3, 5}) fixed[shell_dof(m, i, c)] = 0;
      if (at(mesh.X(i, 1), half))
        for (const int c : {0, 2}) fixed[shell_dof(m, i, c)] = 0;  // diaphragm
    }
    return -solve_shells(shells.K, f, fixed)(3 * n + 2);
  };
  const double a = deflection(8), b = deflection(16), c = deflection(32);
  const bool quads = GetParam() == Faces::quads;
  EXPECT_NEAR(c / 0.3006, 1, quads ? 0.002 : 0.015);
  // Mixed meshes have no limit at the same rate of each kind's share.
  if (GetParam() != Faces::mixed) {
    EXPECT_GE(slope(a - b, b - c), quads ? 1.8 : 1.5);
  }
}

// MacNeal and Harder's twisted beam: every quad is warped. Tip displacement along the
// force, 5.424e-3 in the plane of the tip's section, 1.754e-3 across.
TEST_P(Plate, TwistedBeam) {
  const auto tip = [&](Index n, int component) {
    const double b = 1.1, L = 12;
    const Index across = std::max<Index>(2, n / 6);
    const ShellMesh mesh = shell_grid(GetParam(), n, across, [&](double x, double y) {
      const double s = b * (y - 0.5), turn = pi / 2 * x;
      return Vector3(L * x, s * std::cos(turn), s * std::sin(turn));
    });
    const ShellModel shells = assemble_shells(mesh.faces, mesh.X, {{29e6, 0.22, 1}, 0.32});
    const Index m = mesh.X.rows();
    Prescribed fixed;
    Vector f = Vector::Zero(6 * m);
    for (Index i = 0; i < m; ++i) {
      if (at(mesh.X(i, 0), 0))
        for (int c = 0; c < 6; ++c) fixed[shell_dof(m, i, c)] = 0;
      if (!at(mesh.X(i, 0), L)) continue;
      const bool corner = std::abs(mesh.X(i, 2)) > b / 2 - 1e-9;
      f(3 * i + component) = (corner ? 0.5 : 1.0) / static_cast<double>(across);
    }
    const Vector u = solve_shells(shells.K, f, fixed);
    return f.dot(u);
  };
  for (const int component : {2, 1}) {
    const double reference = component == 2 ? 5.424e-3 : 1.754e-3;
    const double a = tip(12, component), c = tip(48, component);
    EXPECT_NEAR(c / reference, 1, GetParam() == Faces::quads ? 0.002 : 0.03);
    EXPECT_LE(std::abs(c / reference - 1), 0.6 * std::abs(a / reference - 1) + 1e-3);
  }
}

// A square tube twisted between two diaphragms: Bredt's torque, and what the walls add as plates.
TEST_P(Plate, SquareTubeInTorsion) {
  const double a = 1, L = 3, t = 0.02, G = E / (2 * (1 + nu)), twist = 1e-3;
  const auto error = [&](Index n) {
    const Index round = 4 * n;
    ShellMesh mesh = shell_grid(GetParam(), round, 3 * n, [&](double x, double y) {
      const double s = 4 * x, r = s - std::floor(s), h = a / 2;
      const int wall = static_cast<int>(std::floor(s)) % 4;
      const Vector3 corner[] = {{0, -h, -h}, {0, h, -h}, {0, h, h}, {0, -h, h}};
      Vector3 p = (1 - r) * corner[wall] + r * corner[(wall + 1) % 4];
      p(0) = L * y;
      return p;
    });
    for (Index& node : mesh.faces.reshaped())
      if (node % (round + 1) == round) node -= round;  // the seam
    const ShellModel shells = assemble_shells(mesh.faces, mesh.X, {{E, nu, 1}, t});
    const Index m = shells.nodes.size();
    Prescribed fixed;
    for (Index i = 0; i < m; ++i) {
      const Vector3 x = mesh.X.row(shells.nodes[i]).transpose();
      if (at(x(0), 0) || at(x(0), L)) {
        const double angle = at(x(0), L) ? twist : 0;
        fixed[shell_dof(m, i, 1)] = -angle * x(2);
        fixed[shell_dof(m, i, 2)] = angle * x(1);
        fixed[shell_dof(m, i, 3)] = angle;
      }
      if (i == 0) fixed[shell_dof(m, i, 0)] = 0;
    }
    const Vector u = solve_shells(shells.K, Vector::Zero(6 * m), fixed);
    const double torque = u.dot(shells.K * u) / twist;
    return torque / (G * (a * a * a * t + 4 * a * t * t * t / 3) * twist / L) - 1;
  };
  const double fine = error(8);
  EXPECT_LE(std::abs(fine), 0.005);
}

INSTANTIATE_TEST_SUITE_P(Shells, Plate,
                         testing::Values(Faces::quads, Faces::triangles, Faces::mixed));

}  // namespace
}  // namespace cbr::test::shell_convergence_test
