// SPDX-License-Identifier: GPL-3.0-or-later
// A bar of hexes without Poisson's ratio is the textbook chain of two-node bars, whose modes are
// known in closed form: u_i = cos(k x_i), omega^2 = 6 (c/h)^2 (1 - cos kh) / (2 + cos kh) with
// consistent mass, 2 (c/h)^2 (1 - cos kh) with lumped mass.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/fem/assembly.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::bar_dispersion_test {
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

}  // namespace
}  // namespace cbr::test::bar_dispersion_test
