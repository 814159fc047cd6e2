// SPDX-License-Identifier: GPL-3.0-or-later
// Matrices with eigenvalues in closed form: springs on a cubic grid of N^3 points.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/base/types.hpp"

namespace cbr::test {

using Triplets = std::vector<Eigen::Triplet<double, Index>>;

// Unit springs between neighbours. `clamped`: missing neighbours are walls. Eigenvalues are then
// sums of 2 - 2 cos(i pi / (N + 1)), i = 1..N; else of 2 - 2 cos(i pi / N), i = 0..N-1.
inline SparseMatrix grid_stiffness(Index N, bool clamped) {
  const auto at = [N](Index x, Index y, Index z) { return x + N * (y + N * z); };
  Triplets entries;
  for (Index z = 0; z < N; ++z) {
    for (Index y = 0; y < N; ++y) {
      for (Index x = 0; x < N; ++x) {
        double diagonal = 0;
        const Index neighbours[6][3] = {{x - 1, y, z}, {x + 1, y, z}, {x, y - 1, z},
                                        {x, y + 1, z}, {x, y, z - 1}, {x, y, z + 1}};
        for (const auto& p : neighbours) {
          const bool inside = std::min({p[0], p[1], p[2]}) >= 0 && std::max({p[0], p[1], p[2]}) < N;
          if (inside) entries.emplace_back(at(x, y, z), at(p[0], p[1], p[2]), -1.0);
          if (inside || clamped) diagonal += 1;
        }
        entries.emplace_back(at(x, y, z), at(x, y, z), diagonal);
      }
    }
  }
  SparseMatrix K(N * N * N, N * N * N);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

inline Vector grid_eigenvalues(Index N, bool clamped) {
  Vector line(N);
  for (Index i = 0; i < N; ++i) {
    const double angle =
        std::numbers::pi * (clamped ? static_cast<double>(i + 1) / static_cast<double>(N + 1)
                                    : static_cast<double>(i) / static_cast<double>(N));
    line(i) = 2 - 2 * std::cos(angle);
  }
  Vector lambda(N * N * N);
  for (Index i = 0; i < lambda.size(); ++i)
    lambda(i) = line(i % N) + line(i / N % N) + line(i / (N * N));
  std::sort(lambda.begin(), lambda.end());
  return lambda;
}

inline SparseMatrix diagonal_matrix(const Vector& d) {
  SparseMatrix D(d.size(), d.size());
  for (Index i = 0; i < d.size(); ++i) D.insert(i, i) = d(i);
  D.makeCompressed();
  return D;
}

// Positive definite, neither diagonal nor a multiple of the stiffness.
inline SparseMatrix grid_mass(Index N) {
  const Index n = N * N * N;
  Vector d(n);
  for (Index i = 0; i < n; ++i) d(i) = 1 + 0.5 * std::sin(static_cast<double>(i));
  SparseMatrix M = diagonal_matrix(d) + 0.05 * grid_stiffness(N, true);
  M.makeCompressed();
  return M;
}

inline Matrix random_like(Index rows, Index columns, double seed) {
  Matrix B(rows, columns);
  for (Index i = 0; i < B.size(); ++i)
    B.data()[i] = std::sin(seed + 12.9898 * static_cast<double>(i * i % 7919));
  return B;
}

}  // namespace cbr::test
