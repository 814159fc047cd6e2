// SPDX-License-Identifier: GPL-3.0-or-later
// Frequencies of NAFEMS' selected benchmarks for natural frequency analysis (Abbassian, Dawswell,
// Knowles 1987) with solid elements. Steel of the benchmarks: E 200 GPa, nu 0.3, rho 8000 kg/m^3.
#include <gtest/gtest.h>

#include "tests/support/solve.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::nafems_test {
namespace {

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
  const auto nothing = [](const Vector3&, int) { return false; };
  const Mesh mesh = box_mesh(ElementType::hex8, {32, 32, 1}, Vector3(10, 10, 0.05));
  for (const auto& [mass, tolerance] :
       {std::pair{MassKind::consistent, 1.2e-2}, {MassKind::lumped, 5e-3}}) {
    const Vector hz = frequencies(mesh, {steel}, mass, nothing, 14);
    EXPECT_LE(hz.head(6).maxCoeff(), 1e-2 * hz(6));
    expect_near(hz.tail(8), targets, tolerance);
  }
}

}  // namespace
}  // namespace cbr::test::nafems_test
