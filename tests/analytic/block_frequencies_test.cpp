// SPDX-License-Identifier: GPL-3.0-or-later
// Frequencies of the paper's block (0.0508 x 0.0254 x 0.0381, E 5.17e12, nu 0.3, rho 7836) against
// two independent computations: a finite element program written apart from this one (8-node hexes,
// 2 x 2 x 2 points, consistent mass, 20 x 10 x 15), to its digits, and Ritz's method with Legendre
// polynomials (10 x 9 x 10), which bounds the exact frequencies from above closely.
#include <gtest/gtest.h>

#include "tests/support/solve.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::block_frequencies_test {
namespace {

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

}  // namespace
}  // namespace cbr::test::block_frequencies_test
