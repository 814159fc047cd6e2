// SPDX-License-Identifier: GPL-3.0-or-later

#include <gtest/gtest.h>

#include <vector>

#include "common/linalg/dense.hpp"
#include "reducer/condensation/condensation.hpp"

namespace cbr::reached_compliance_test {
namespace {

// Springs between neighbours of a cube of n^3 points, each held a little.
SparseMatrix springs(Index n) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  const auto add = [&](Index a, Index b) {
    entries.emplace_back(a, a, 1);
    entries.emplace_back(b, b, 1);
    entries.emplace_back(a, b, -1);
    entries.emplace_back(b, a, -1);
  };
  for (Index k = 0; k < n; ++k)
    for (Index j = 0; j < n; ++j)
      for (Index i = 0; i < n; ++i) {
        const Index at = i + n * (j + n * k);
        entries.emplace_back(at, at, 0.01);
        if (i + 1 < n) add(at, at + 1);
        if (j + 1 < n) add(at, at + n);
        if (k + 1 < n) add(at, at + n * n);
      }
  SparseMatrix A(n * n * n, n * n * n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

// Forces on pairs of points of one face, and one without any.
SparseMatrix forces(Index n) {
  SparseMatrix B(n * n * n, n * n);
  for (Index j = 0; j + 1 < n * n; ++j) {
    B.insert(j, j) = 1;
    B.insert(j + 1, j) = 0.5 + static_cast<double>(j % 3);
  }
  B.makeCompressed();
  return B;
}

// With room for the square of L^-1 B, and with room for one column: back to the forces.
TEST(ReachedCompliance, IsWhatDenseMatricesGive) {
  constexpr Index n = 8;
  const SparseMatrix A = springs(n), B = forces(n);
  const Matrix expected = Matrix(B).transpose() * Ldlt(Matrix(A)).solve(Matrix(B));
  std::vector<Index> face;
  for (Index i = 0; i < n * n; ++i) face.push_back(i);
  for (const std::vector<Index>& last : {std::vector<Index>(), face}) {
    const SparseCholesky factor(A, last);
    for (const double bytes : {1e9, 1.0}) {
      const Matrix C = reached_compliance(factor, B, bytes);
      EXPECT_LT((C - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
      EXPECT_TRUE(C == C.transpose());
    }
  }
}

}  // namespace
}  // namespace cbr::reached_compliance_test
