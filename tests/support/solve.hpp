// SPDX-License-Identifier: GPL-3.0-or-later
// From a finite element model to frequencies and static solutions, for tests.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <vector>

#include "common/fem/assembly.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"

namespace cbr::test {

// fixed(x, c): whether component c of a node at x is constrained
using Support = std::function<bool(const Vector3&, int)>;

inline std::vector<Index> free_dofs(const Mesh& mesh, const FiniteElementModel& model,
                                    const Support& fixed) {
  std::vector<Index> dofs;
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (!fixed(mesh.coordinates.row(model.nodes[i]).transpose(), c))
        dofs.push_back(3 * static_cast<Index>(i) + c);
  return dofs;
}

// A(dofs, dofs), dofs ascending.
inline SparseMatrix submatrix(const SparseMatrix& A, const std::vector<Index>& dofs) {
  std::vector<Index> place(A.rows(), -1);
  for (std::size_t i = 0; i < dofs.size(); ++i) place[dofs[i]] = static_cast<Index>(i);
  SparseMatrix B(static_cast<Index>(dofs.size()), static_cast<Index>(dofs.size()));
  B.reserve(A.nonZeros());
  for (Index j = 0; j < B.cols(); ++j) {
    B.startVec(j);
    for (SparseMatrix::InnerIterator entry(A, dofs[j]); entry; ++entry)
      if (const Index row = place[entry.row()]; row >= 0) B.insertBack(row, j) = entry.value();
  }
  B.finalize();
  return B;
}

// The lowest k frequencies in Hz, including rigid motions (zeros).
inline Vector frequencies(const Mesh& mesh, const BlockProperties& properties, MassKind mass,
                          const Support& fixed, Index k) {
  const auto model =
      assemble(mesh, std::vector<BlockProperties>(mesh.blocks.size(), properties), mass);
  const auto dofs = free_dofs(mesh, model, fixed);
  const SparseMatrix K = submatrix(model.K, dofs), M = submatrix(model.M, dofs);
  // Shift far below the first elastic eigenvalue of these meshes, and far above the round-off of
  // zero ones.
  const double sigma = -1e-6 * K.diagonal().sum() / M.diagonal().sum();
  const SparseMatrix shifted = K - sigma * M;
  // A few more modes: Lanczos from one vector may find only one of two equal eigenvalues at the end
  const auto pairs = sparse_eigenpairs(K, M, SparseCholesky(shifted), sigma, k + 6);
  EXPECT_TRUE(pairs.converged);
  return pairs.lambda.head(k).cwiseMax(0).cwiseSqrt() / (2 * std::numbers::pi);
}

}  // namespace cbr::test
