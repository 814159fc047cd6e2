// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/shell_model.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/shell_mesh.hpp"

namespace cbr::test::shell_model_test {
namespace {

const Material steel = {210e9, 0.3, 7850};

// The surface of a box of n x n x n cells: corners, edges where shells meet at right angles.
ShellMesh box_surface(Index n, const Vector3& size) {
  std::map<std::array<Index, 3>, Index> number;
  std::vector<std::array<Index, 4>> faces;
  const auto node = [&](std::array<Index, 3> g) {
    return number.try_emplace(g, static_cast<Index>(number.size())).first->second;
  };
  for (std::size_t c = 0; c < 3; ++c)
    for (const Index side : {Index(0), n})
      for (Index i = 0; i < n; ++i)
        for (Index j = 0; j < n; ++j) {
          const auto at = [&](Index di, Index dj) {
            std::array<Index, 3> g{};
            g[c] = side;
            g[(c + 1) % 3] = i + di;
            g[(c + 2) % 3] = j + dj;
            return node(g);
          };
          faces.push_back({at(0, 0), at(1, 0), at(1, 1), at(0, 1)});
        }
  ShellMesh mesh;
  mesh.X.resize(static_cast<Index>(number.size()), 3);
  for (const auto& [g, i] : number)
    for (std::size_t c = 0; c < 3; ++c)
      mesh.X(i, static_cast<Index>(c)) =
          size(static_cast<Index>(c)) * static_cast<double>(g[c]) / static_cast<double>(n);
  mesh.faces.resize(static_cast<Index>(faces.size()), 4);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (Index i = 0; i < 4; ++i) mesh.faces(static_cast<Index>(f), i) = faces[f][i];
  return mesh;
}

ShellMesh wavy(Faces kind) {
  return shell_grid(kind, 4, 3, [](double x, double y) {
    return Vector3(2 * x, y + 0.2 * x, 0.1 * std::sin(4 * x) * y);
  });
}

TEST(ShellModel, NothingIsEmpty) {
  const ShellMesh mesh = wavy(Faces::mixed);
  for (const ShellProperties& shell :
       {ShellProperties{{0, 0.3, 0}, 1e-3}, ShellProperties{steel, 0},
        ShellProperties{{1e-200, 0.3, 1e-200}, 1e-200}}) {
    const ShellModel model = assemble_shells(mesh.faces, mesh.X, shell);
    EXPECT_TRUE(model.empty());
    EXPECT_TRUE(model.nodes.empty());
    EXPECT_FALSE(model.has_rotations());
  }
  EXPECT_TRUE(assemble_shells(IndexTable(0, 4), mesh.X, {steel, 1}).empty());
}

TEST(ShellModel, NodesAreThoseOfTheFaces) {
  ShellMesh mesh = wavy(Faces::quads);
  const ShellModel whole = assemble_shells(mesh.faces, mesh.X, {steel, 0.01});
  Points more(mesh.X.rows() + 3, 3);
  more << Points::Constant(2, 3, std::nan("")), mesh.X, Points::Zero(1, 3);
  const ShellModel model = assemble_shells(mesh.faces.array() + 2, more, {steel, 0.01});
  ASSERT_EQ(model.nodes.size(), whole.nodes.size());
  EXPECT_EQ(model.nodes.front(), 2);
  EXPECT_EQ(Matrix(model.K), Matrix(whole.K));
  EXPECT_EQ(model.mass, whole.mass);
}

TEST(ShellModel, DensityWithoutStiffnessHasNoRotations) {
  const ShellMesh mesh = wavy(Faces::triangles);
  const ShellModel model = assemble_shells(mesh.faces, mesh.X, {{0, 0.3, 7850}, 0.01});
  EXPECT_FALSE(model.has_rotations());
  EXPECT_EQ(model.K.size(), 0);
  EXPECT_FALSE(model.empty());
  EXPECT_EQ(model.mass, assemble_shells(mesh.faces, mesh.X, {steel, 0.01}).mass);
  EXPECT_GT(model.mass.minCoeff(), 0);
}

TEST(ShellModel, RigidMotionsAndNoOthers) {
  for (const ShellMesh& mesh :
       {wavy(Faces::quads), wavy(Faces::mixed), box_surface(3, {1, 0.7, 0.4})}) {
    const ShellModel model = assemble_shells(mesh.faces, mesh.X, {steel, 0.02});
    const Matrix K(model.K);
    EXPECT_EQ(K, Matrix(K.transpose()));
    EXPECT_LE((K * shell_rigid_modes(mesh.X)).cwiseAbs().maxCoeff(),
              1e-13 * K.cwiseAbs().maxCoeff());
    const Vector lambda = symmetric_eigenvalues(K);
    EXPECT_LE(lambda.head(6).cwiseAbs().maxCoeff(), 1e-14 * lambda.maxCoeff());
    EXPECT_GE(lambda(6), 1e-8 * lambda.maxCoeff());
  }
}

// Without density: the dense Schur complement, and no less rigid motions than before.
TEST(ShellModel, RotationsAreCondensed) {
  for (const ShellMesh& mesh : {wavy(Faces::mixed), box_surface(3, {1, 0.7, 0.4})}) {
    const Index m = mesh.X.rows();
    const ShellModel whole = assemble_shells(mesh.faces, mesh.X, {steel, 0.02});
    const ShellModel model = assemble_shells(
        mesh.faces, mesh.X, {{steel.youngs_modulus, steel.poissons_ratio, 0}, 0.02});
    ASSERT_EQ(model.K.rows(), 3 * m);
    EXPECT_EQ(model.mass.size(), 0);
    EXPECT_FALSE(model.has_rotations());
    const Matrix K(whole.K), S(model.K);
    const Matrix schur =
        K.topLeftCorner(3 * m, 3 * m) -
        K.topRightCorner(3 * m, 3 * m) *
            Lu(K.bottomRightCorner(3 * m, 3 * m)).solve(K.bottomLeftCorner(3 * m, 3 * m));
    EXPECT_LE((S - schur).cwiseAbs().maxCoeff(), 1e-11 * schur.cwiseAbs().maxCoeff());
    EXPECT_LE((S * rigid_modes(mesh.X, Vector3::Zero())).cwiseAbs().maxCoeff(),
              1e-12 * S.cwiseAbs().maxCoeff());
    EXPECT_EQ(S, Matrix(S.transpose()));
  }
}

// The paper's thinnest shell, tilted, so that its bending drowns in the round-off of its membrane;
// and thinner.
TEST(ShellModel, VeryThinShellsAreCondensedToo) {
  for (const ShellMesh& mesh : {wavy(Faces::quads), box_surface(4, {0.0508, 0.0254, 0.0381})})
    for (const double t : {2.5e-10, 1e-100, 1e-290}) {
      const ShellModel model = assemble_shells(mesh.faces, mesh.X, {{6.9e3, 0.3, 0}, t});
      ASSERT_EQ(model.K.rows(), 3 * mesh.X.rows()) << t;
      const Matrix S = Matrix(model.K) / (6.9e3 * t);
      ASSERT_TRUE(S.allFinite()) << t;
      EXPECT_LE((S * rigid_modes(mesh.X, Vector3::Zero())).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_GE(symmetric_eigenvalues(S).minCoeff(), -1e-12);
    }
}

// omega_max of the free shells, rotations with their inertia, over that of the membrane alone: the
// rotations do not set the step.
TEST(ShellModel, RotationsDoNotSetTheStep) {
  const auto top = [](const Matrix& A) { return std::sqrt(symmetric_eigenvalues(A).maxCoeff()); };
  double highest = 0;
  for (const Faces kind : {Faces::quads, Faces::triangles, Faces::mixed})
    for (const double aspect : {1.0, 5.0})
      for (const double t : {1e-9, 0.1, 1.0, 2.0, 20.0}) {
        const ShellMesh mesh = shell_grid(kind, 4, 4, [&](double x, double y) {
          return Vector3(aspect * 4 * (x + 0.03 * std::sin(9 * y)),
                         4 * (y + 0.03 * std::sin(7 * x)), 0);
        });
        const ShellModel model = assemble_shells(mesh.faces, mesh.X, {steel, t});
        const Index m = mesh.X.rows();
        Vector root(6 * m);
        std::vector<Index> membrane, drilling;
        for (Index i = 0; i < 3 * m; ++i) {
          root(i) = 1 / std::sqrt(model.mass(i / 3));
          root(3 * m + i) = 1 / std::sqrt(model.rotary(i / 3));
          if (i % 3 < 2) membrane.push_back(i);
          if (i % 3 == 2) drilling.push_back(3 * m + i);
        }
        const Matrix A = root.asDiagonal() * Matrix(model.K) * root.asDiagonal();
        const Matrix A_dd = A(drilling, drilling), A_dm = A(drilling, membrane);
        const Matrix own =
            Matrix(A(membrane, membrane)) - A_dm.transpose() * Cholesky(A_dd).solve(A_dm);
        highest = std::max(highest, top(A) / top(own));
      }
  RecordProperty("highest", std::to_string(highest));
  EXPECT_LE(highest, 1.03);
}

TEST(ShellModel, NeverNaN) {
  const ShellMesh mesh = wavy(Faces::mixed);
  int refused = 0, empty = 0;
  for (const double E : {0.0, 1e-300, 1.0, 1e300})
    for (const double rho : {0.0, 1e-300, 1.0, 1e300})
      for (const double t : {1e-300, 1e-160, 1.0, 1e160, 1e300})
        for (const double size : {1e-100, 1.0, 1e100}) try {
            const ShellModel model = assemble_shells(mesh.faces, mesh.X * size, {{E, 0.3, rho}, t});
            EXPECT_TRUE(Matrix(model.K).allFinite() && model.mass.allFinite() &&
                        model.rotary.allFinite())
                << E << rho << t << size;
            EXPECT_TRUE(model.rotary.size() == 0 || model.rotary.minCoeff() > 0);
            empty += model.empty();
          } catch (const InputError&) {
            ++refused;
          }
  EXPECT_GT(refused, 10);
  EXPECT_GT(empty, 10);
}

TEST(ShellModel, RefusesByName) {
  ShellMesh mesh = wavy(Faces::quads);
  const auto run = [&](const ShellProperties& shell) {
    return test::refusal_of([&] { assemble_shells(mesh.faces, mesh.X, shell); });
  };
  EXPECT_SAYS(run({{std::nan(""), 0.3, 1}, 1}), "youngs_modulus");
  EXPECT_SAYS(run({{1, 0.7, 1}, 1}), "poissons_ratio is 0.7");
  EXPECT_SAYS(run({{1, 0.3, -1}, 1}), "density is -1");
  EXPECT_SAYS(run({{1, 0.3, 1}, std::numeric_limits<double>::infinity()}), "thickness");
  EXPECT_SAYS(run({{1e300, 0.3, 1}, 1e200}), "exceeds what a double can hold");
  const ShellMesh sound = mesh;
  mesh.X.row(6) = mesh.X.row(0);  // of face 0: 0, 1, 6, 5
  EXPECT_SAYS(run({steel, 1}), "face 0 (nodes of rows 0, 1, 6, 5) is degenerate");
  mesh = sound;
  mesh.X(6, 0) = std::nan("");
  EXPECT_SAYS(run({steel, 1}), "is degenerate");
  mesh = sound;
  mesh.faces.row(3) << 0, 1, 2, 2;
  mesh.X.row(2) = 2 * mesh.X.row(1) - mesh.X.row(0);  // on a line
  EXPECT_SAYS(run({steel, 1}), "degenerate");
  mesh = sound;
  mesh.faces(2, 1) = 999;
  EXPECT_SAYS(run({steel, 1}), "row 999 of 20");
  mesh = shell_grid(Faces::quads, 71, 71, [](double x, double y) { return Vector3(x, y, 0); });
  EXPECT_SAYS(run({{1, 0.3, 0}, 1}), "5184 nodes with a modulus but no density");
}

}  // namespace
}  // namespace cbr::test::shell_model_test
