// SPDX-License-Identifier: GPL-3.0-or-later
// A bar of hexes without Poisson's ratio is the textbook chain of two-node bars, whose modes are
// known in closed form: u_i = cos(k x_i), omega^2 = 6 (c/h)^2 (1 - cos kh) / (2 + cos kh) with
// consistent mass, 2 (c/h)^2 (1 - cos kh) with lumped mass.
// Frequencies of the paper's block (0.0508 x 0.0254 x 0.0381, E 5.17e12, nu 0.3, rho 7836) against
// two independent computations: a finite element program written apart from this one (8-node hexes,
// 2 x 2 x 2 points, consistent mass, 20 x 10 x 15), to its digits, and Ritz's method with Legendre
// polynomials (10 x 9 x 10), which bounds the exact frequencies from above closely.
// Frequencies of NAFEMS' selected benchmarks for natural frequency analysis (Abbassian, Dawswell,
// Knowles 1987) with solid elements. Steel of the benchmarks: E 200 GPa, nu 0.3, rho 8000 kg/m^3.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/fem/assembly.hpp"
#include "tests/support/solve.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::frequencies_test {
namespace {

class BarDispersion : public testing::TestWithParam<std::tuple<HexFormulation, MassKind>> {};

TEST_P(BarDispersion, DiscreteModesAreTheChains) {
  const auto [formulation, mass] = GetParam();
  const Index n = 7;
  const double length = 1.4, h = length / static_cast<double>(n), E = 210e9, rho = 7850;
  const Mesh mesh = box_mesh(ElementType::hex8, {n, 2, 1}, Vector3(length, 0.1, 0.1));
  const auto model = assemble(mesh, {{{E, 0, rho}, formulation}}, mass);
  const double scale = E / rho / (h * h);
  for (int mode = 1; mode <= n; ++mode) {
    const double k = mode * std::numbers::pi / length, cosine = std::cos(k * h);
    const double omega2 = mass == MassKind::consistent ? 6 * scale * (1 - cosine) / (2 + cosine)
                                                       : 2 * scale * (1 - cosine);
    Vector u = Vector::Zero(model.K.rows());
    for (Index i = 0; i < mesh.coordinates.rows(); ++i)
      u(3 * i) = std::cos(k * mesh.coordinates(i, 0));
    const Vector force = model.K * u;
    EXPECT_LE((force - omega2 * (model.M * u)).norm(), 1e-12 * force.norm()) << "mode " << mode;
  }
}

INSTANTIATE_TEST_SUITE_P(All, BarDispersion,
                         testing::Combine(testing::Values(HexFormulation::full,
                                                          HexFormulation::incompatible,
                                                          HexFormulation::hourglass),
                                          testing::Values(MassKind::consistent, MassKind::lumped)));

const Vector3 size(0.0508, 0.0254, 0.0381);
const Material material = {5.17e12, 0.3, 7836};

bool nothing(const Vector3&, int) { return false; }
bool x_face(const Vector3& x, int) { return x(0) < 1e-9; }
bool x_faces(const Vector3& x, int) { return x(0) < 1e-9 || x(0) > size(0) - 1e-9; }
bool surface(const Vector3& x, int) { return x.minCoeff() < 1e-9 || (size - x).minCoeff() < 1e-9; }

// Relative to half a unit of the last digit of values given in kHz with three decimals.
void expect_digits(const Vector& hz, const std::vector<double>& khz) {
  for (std::size_t i = 0; i < khz.size(); ++i)
    EXPECT_NEAR(hz(static_cast<Index>(i)) / 1000, khz[i], 6e-4) << "mode " << i + 1;
}

Vector fine_hex8(const Support& fixed, Index k) {
  const Mesh mesh = box_mesh(ElementType::hex8, {20, 10, 15}, size);
  return frequencies(mesh, {material, HexFormulation::full}, MassKind::consistent, fixed, k);
}

const std::vector<double> ritz_free = {129.162, 163.185, 191.942, 227.808, 241.383, 245.744,
                                       253.992, 267.040, 277.451, 289.462, 295.197, 295.209};

TEST(BlockFrequencies, FreeHex8) {
  const Vector hz = fine_hex8(nothing, 18);
  EXPECT_LE(hz.head(6).maxCoeff(), 1e-4 * hz(6));
  expect_digits(hz.tail(12), {129.706, 164.194, 192.796, 228.739, 241.827, 247.529, 256.308,
                              269.355, 279.535, 291.078, 297.150, 297.659});
}

TEST(BlockFrequencies, ClampedHex8) {
  expect_digits(fine_hex8(x_face, 8),
                {35.793, 46.366, 69.300, 128.204, 134.734, 142.567, 201.259, 257.638});
  expect_digits(fine_hex8(x_faces, 6), {129.981, 139.534, 144.360, 254.691, 258.345, 262.748});
  expect_digits(fine_hex8(surface, 5), {464.188, 503.493, 530.094, 603.654, 617.750});
}

struct Case {
  ElementType type;
  std::array<Index, 3> cells;
  double above;  // relative to Ritz
};

class Converged : public testing::TestWithParam<Case> {};

TEST_P(Converged, FreeBlockAgreesWithRitz) {
  const auto [type, cells, above] = GetParam();
  const Vector hz =
      frequencies(box_mesh(type, cells, size), {material}, MassKind::consistent, nothing, 18);
  for (std::size_t i = 0; i < ritz_free.size(); ++i) {
    const double error = hz(6 + static_cast<Index>(i)) / (1000 * ritz_free[i]) - 1;
    EXPECT_LE(error, above) << "mode " << i + 1;
    // Compatible elements bound from above; Ritz's own error is a few 1e-5.
    EXPECT_GE(error, type == ElementType::hex8 ? -0.004 : -1e-4) << "mode " << i + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, Converged,
                         testing::Values(Case{ElementType::hex20, {8, 4, 6}, 1e-3},
                                         Case{ElementType::hex27, {8, 4, 6}, 1e-3},
                                         Case{ElementType::tet10, {8, 4, 6}, 4e-3},
                                         Case{ElementType::hex8, {20, 10, 15}, 8e-3}));

const Material steel = {200e9, 0.3, 8000};

void expect_near(const Vector& hz, const std::vector<double>& targets, double tolerance) {
  for (std::size_t i = 0; i < targets.size(); ++i)
    EXPECT_NEAR(hz(static_cast<Index>(i)), targets[i], tolerance * targets[i]) << "mode " << i + 1;
}

// FV52: simply supported solid square plate, 10 x 10 x 1, w = 0 on the four edge faces. Three rigid
// motions in the plane. The benchmark's targets are thick-plate theory, of which three-dimensional
// elasticity (Ritz) differs by up to 4 %.
bool edges_in_z(const Vector3& x, int c) {
  return c == 2 && (x.head<2>().minCoeff() < 1e-9 || x.head<2>().maxCoeff() > 10 - 1e-9);
}
const std::vector<double> fv52_elasticity = {44.18,  107.33, 107.33, 163.12, 193.65,
                                             203.30, 203.65, 206.80, 206.80};
const std::vector<double> fv52_nafems = {45.897, 109.44, 109.44, 167.89, 193.59, 206.19, 206.19};

class SolidPlate : public testing::TestWithParam<
                       std::tuple<ElementType, std::array<Index, 3>, MassKind, double>> {};

TEST_P(SolidPlate, Fv52) {
  const auto& [type, cells, mass, tolerance] = GetParam();
  const Vector hz =
      frequencies(box_mesh(type, cells, Vector3(10, 10, 1)), {steel}, mass, edges_in_z, 12);
  EXPECT_LE(hz.head(3).maxCoeff(), 1e-4 * hz(3));
  expect_near(hz.tail(9), fv52_elasticity, tolerance);
  expect_near(hz.tail(9), fv52_nafems, 0.04);
}

INSTANTIATE_TEST_SUITE_P(
    Elements, SolidPlate,
    testing::Values(
        std::tuple{ElementType::hex20, std::array<Index, 3>{16, 16, 3}, MassKind::consistent, 1e-3},
        std::tuple{ElementType::hex8, std::array<Index, 3>{24, 24, 4}, MassKind::consistent,
                   2.5e-2},
        std::tuple{ElementType::hex8, std::array<Index, 3>{24, 24, 4}, MassKind::lumped, 5e-3}));

// FV32: cantilevered tapered membrane, 10 long, 5 to 1 wide, 0.05 thick. Half its thickness, w = 0
// in the middle plane: what is left are the membrane's motions.
TEST(Membrane, Fv32) {
  const std::vector<double> targets = {44.623, 130.03, 162.70, 246.05, 379.90, 391.44};
  const auto taper = [](const Vector3& x) -> Vector3 {
    return Vector3(x(0), (2 * x(1) - 1) * (2.5 - 0.2 * x(0)), x(2));
  };
  const auto root = [](const Vector3& x, int c) { return c == 2 ? x(2) < 1e-9 : x(0) < 1e-9; };
  const Mesh quadratic = box_mesh(ElementType::hex20, {16, 8, 1}, Vector3(10, 1, 0.025), taper);
  expect_near(frequencies(quadratic, {steel}, MassKind::consistent, root, 6), targets, 2e-4);
  const Mesh linear = box_mesh(ElementType::hex8, {32, 16, 1}, Vector3(10, 1, 0.025), taper);
  expect_near(frequencies(linear, {steel}, MassKind::consistent, root, 6), targets, 1e-2);
}

// FV12: free thin square plate, 10 x 10 x 0.05: bricks six times as wide as they are thick.
TEST(ThinPlate, Fv12) {
  const std::vector<double> targets = {1.622, 2.360, 2.922, 4.190, 4.190, 7.356, 7.356, 7.668};
  const Mesh mesh = box_mesh(ElementType::hex8, {32, 32, 1}, Vector3(10, 10, 0.05));
  for (const auto& [mass, tolerance] :
       {std::pair{MassKind::consistent, 1.2e-2}, {MassKind::lumped, 5e-3}}) {
    const Vector hz = frequencies(mesh, {steel}, mass, nothing, 14);
    EXPECT_LE(hz.head(6).maxCoeff(), 1e-2 * hz(6));
    expect_near(hz.tail(8), targets, tolerance);
  }
}

}  // namespace
}  // namespace cbr::test::frequencies_test
