// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces of triangles and quads, and linear shell systems on them, for tests.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <map>
#include <vector>

#include "common/fem/shell_model.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "tests/support/solve.hpp"

namespace cbr::test {

enum class Faces { quads, triangles, mixed };

inline void PrintTo(Faces faces, std::ostream* out) {
  *out << (faces == Faces::quads ? "quads" : faces == Faces::triangles ? "triangles" : "mixed");
}

struct ShellMesh {
  Points X;
  IndexTable faces;  // f x 4
};

// n_x x n_y cells of [0, 1]^2, mapped to space. Node j (n_x + 1) + i is at (i / n_x, j / n_y).
// Diagonals of triangles alternate.
inline ShellMesh shell_grid(Faces kind, Index n_x, Index n_y,
                            const std::function<Vector3(double, double)>& map) {
  ShellMesh mesh;
  mesh.X.resize((n_x + 1) * (n_y + 1), 3);
  for (Index j = 0; j <= n_y; ++j)
    for (Index i = 0; i <= n_x; ++i)
      mesh.X.row(j * (n_x + 1) + i) = map(static_cast<double>(i) / static_cast<double>(n_x),
                                          static_cast<double>(j) / static_cast<double>(n_y))
                                          .transpose();
  std::vector<std::array<Index, 4>> faces;
  for (Index j = 0; j < n_y; ++j)
    for (Index i = 0; i < n_x; ++i) {
      const Index a = j * (n_x + 1) + i, b = a + 1, d = a + n_x + 1, c = d + 1;
      if (kind == Faces::quads || (kind == Faces::mixed && (i + 2 * j) % 3 != 0)) {
        faces.push_back({a, b, c, d});
      } else if ((i + j) % 2 == 0) {
        faces.push_back({a, b, c, c});
        faces.push_back({a, c, d, d});
      } else {
        faces.push_back({a, b, d, d});
        faces.push_back({b, c, d, d});
      }
    }
  mesh.faces.resize(static_cast<Index>(faces.size()), 4);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (Index i = 0; i < 4; ++i) mesh.faces(static_cast<Index>(f), i) = faces[f][i];
  return mesh;
}

// Dofs of node i of m: 0 1 2 translations, 3 4 5 rotations.
inline Index shell_dof(Index m, Index i, int c) {
  return c < 3 ? 3 * i + c : 3 * m + 3 * i + c - 3;
}

// Solves K u = f with u prescribed at some dofs (f there is ignored).
inline Vector solve_shells(const SparseMatrix& K, Vector f,
                           const std::map<Index, double>& prescribed) {
  Vector u = Vector::Zero(K.rows());
  for (const auto& [dof, value] : prescribed) u(dof) = value;
  f -= K * u;
  std::vector<Index> free;
  for (Index i = 0; i < K.rows(); ++i)
    if (!prescribed.contains(i)) free.push_back(i);
  const SparseCholesky factor(submatrix(K, free));
  EXPECT_TRUE(factor.ok());
  Vector b(static_cast<Index>(free.size()));
  for (std::size_t i = 0; i < free.size(); ++i) b(static_cast<Index>(i)) = f(free[i]);
  factor.solve(b.data(), b.data());
  for (std::size_t i = 0; i < free.size(); ++i) u(free[i]) = b(static_cast<Index>(i));
  return u;
}

// The 6 m x 6 rigid motions.
inline Matrix shell_rigid_modes(const Points& X) {
  const Index m = X.rows();
  Matrix R = Matrix::Zero(6 * m, 6);
  R.topRows(3 * m) = rigid_modes(X, X.colwise().mean().transpose());
  for (Index i = 0; i < m; ++i) R.block<3, 3>(3 * m + 3 * i, 3) = Matrix3::Identity();
  return R;
}

}  // namespace cbr::test
