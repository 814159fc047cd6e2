// SPDX-License-Identifier: GPL-3.0-or-later
// Orders of convergence, as slopes between two meshes of smoothly warped elements: p + 1 for
// displacements, 2 p for frequencies.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "common/fem/elements/reference_element.hpp"
#include "common/scene/scene_words.hpp"
#include "tests/support/solve.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::element_convergence_test {
namespace {

using std::numbers::pi;

struct Case {
  ElementType type;
  HexFormulation hex;
  int degree;
  Index coarse;  // cells along an edge; the fine mesh has twice as many
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << element_word(std::string(name(c.type)), c.hex);
}

const Material material = {1, 0.3, 1};
const Vector3 box(1, 0.8, 1.3);

// Maps the box to itself; the faces stay in their planes.
Vector3 warp(const Vector3& x) {
  const Vector3 s = (pi * x.array() / box.array()).sin();
  const Vector3 c = (pi * x.array() / box.array()).cos();
  return x + 0.06 * Vector3(s(0) * c(1), s(1) * c(2), s(2) * c(0));
}

bool on_face(const Vector3& x, int c) { return x(c) < 1e-9 || x(c) > box(c) - 1e-9; }

class Convergence : public testing::TestWithParam<Case> {
 protected:
  BlockProperties properties() const { return {material, GetParam().hex, true}; }
  Mesh mesh(Index n) const { return box_mesh(GetParam().type, {n, n, n}, box, warp); }
};

// A displacement in equilibrium without loads: the gradient of the harmonic function exp(sqrt(2) x)
// sin(y) cos(z).
Vector3 harmonic(const Vector3& x) {
  const double root = std::sqrt(2.0), e = std::exp(root * x(0));
  return e * Vector3(root * std::sin(x(1)) * std::cos(x(2)), std::cos(x(1)) * std::cos(x(2)),
                     -std::sin(x(1)) * std::sin(x(2)));
}

// Root of the integral of |u_h - u|^2.
double displacement_error(const Mesh& mesh, const Vector& u) {
  const Block& block = mesh.blocks[0];
  const ShapeTable& table = reference_element(block.type).mass;
  double sum = 0;
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    const Points X = points_of(mesh, block, e);
    Points u_e(X.rows(), 3);
    for (Index i = 0; i < X.rows(); ++i)
      u_e.row(i) = u.segment<3>(3 * block.connectivity(e, i)).transpose();
    for (Index q = 0; q < table.size(); ++q) {
      const auto p = static_cast<std::size_t>(q);
      const Vector3 x = X.transpose() * table.N.col(q), u_h = u_e.transpose() * table.N.col(q);
      const Matrix3 J = table.dN[p].transpose() * X;
      sum += table.weight[p] * J.determinant() * (u_h - harmonic(x)).squaredNorm();
    }
  }
  return std::sqrt(sum);
}

double static_error(const Mesh& mesh, const BlockProperties& properties) {
  const auto model = assemble(mesh, {properties}, MassKind::lumped);
  Vector u(model.K.rows());
  for (Index i = 0; i < mesh.coordinates.rows(); ++i)
    u.segment<3>(3 * i) = harmonic(mesh.coordinates.row(i).transpose());
  const auto boundary = [](const Vector3& x, int) {
    return on_face(x, 0) || on_face(x, 1) || on_face(x, 2);
  };
  const auto I = free_dofs(mesh, model, boundary);
  // Entry by entry: at -O2 GCC 12 takes what u(I) = ... frees for memory that is not on the heap.
  for (const Index i : I) u(i) = 0;
  const Vector force = model.K * u;
  const Matrix u_I = SparseCholesky(submatrix(model.K, I)).solve(Matrix(-force(I)));
  for (std::size_t i = 0; i < I.size(); ++i) u(I[i]) = u_I(static_cast<Index>(i), 0);
  return displacement_error(mesh, u);
}

TEST_P(Convergence, Displacements) {
  const double coarse = static_error(mesh(GetParam().coarse), properties());
  const double fine = static_error(mesh(2 * GetParam().coarse), properties());
  const double slope = std::log2(coarse / fine);
  RecordProperty("slope", std::to_string(slope));
  EXPECT_GE(slope, GetParam().degree + 1 - 0.2) << coarse << " to " << fine;
  EXPECT_LE(slope, GetParam().degree + 1 + 0.6) << coarse << " to " << fine;
}

// A box whose faces slide on smooth rigid walls has shear and pressure waves for modes. The lowest
// one is a shear wave in the plane of the two longest edges: omega = c_s pi sqrt(1/a^2 + 1/b^2),
// c_s^2 = mu / rho.
TEST_P(Convergence, Frequencies) {
  const double c_s = std::sqrt(1 / 2.6);
  const double exact = c_s / 2 * std::sqrt(1 / (box(0) * box(0)) + 1 / (box(2) * box(2)));
  const auto error = [&](Index n) {
    return frequencies(mesh(n), properties(), MassKind::consistent, on_face, 2)(0) / exact - 1;
  };
  const double coarse = error(GetParam().coarse), fine = error(2 * GetParam().coarse);
  const double slope = std::log2(std::abs(coarse / fine));
  RecordProperty("slope", std::to_string(slope));
  EXPECT_GE(slope, 2 * GetParam().degree - 0.3) << coarse << " to " << fine;
  EXPECT_LE(slope, 2 * GetParam().degree + 0.8) << coarse << " to " << fine;
}

INSTANTIATE_TEST_SUITE_P(Elements, Convergence,
                         testing::Values(Case{ElementType::tet4, HexFormulation::full, 1, 6},
                                         Case{ElementType::pyramid5, HexFormulation::full, 1, 5},
                                         Case{ElementType::wedge6, HexFormulation::full, 1, 6},
                                         Case{ElementType::hex8, HexFormulation::full, 1, 6},
                                         Case{ElementType::hex8, HexFormulation::incompatible, 1,
                                              6},
                                         Case{ElementType::hex8, HexFormulation::hourglass, 1, 6},
                                         Case{ElementType::hex8, HexFormulation::reduced, 1, 12},
                                         Case{ElementType::tet10, HexFormulation::full, 2, 4},
                                         Case{ElementType::hex20, HexFormulation::full, 2, 3},
                                         Case{ElementType::hex20, HexFormulation::reduced, 2, 3},
                                         Case{ElementType::wedge15, HexFormulation::full, 2, 3},
                                         Case{ElementType::hex27, HexFormulation::full, 2, 3}));

}  // namespace
}  // namespace cbr::test::element_convergence_test
