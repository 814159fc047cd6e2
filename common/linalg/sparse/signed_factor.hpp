// SPDX-License-Identifier: GPL-3.0-or-later
// A factor of K - sigma M with sigma inside the spectrum.
#pragma once

#include <memory>
#include <vector>

#include "common/linalg/sparse/fronts.hpp"
#include "common/linalg/sparse/shared_solve.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"

namespace cbr {

// K - sigma M = P^T L S L^T P, S = +-1 on the diagonal, for shifts that lie between eigenvalues. A
// part of few dofs has eigenvalues far above such a sigma, so that only the last separators have
// negative pivots. These are chosen among the neighbours of a front (supernodal_ldl.hpp).
class SignedFactor {
 public:
  // In the elimination order of `like`, which must outlive this object. `like`: factor of a matrix
  // with the pattern of K and M (n x n, both triangles stored).
  SignedFactor(const SparseMatrix& K, double sigma, const SparseMatrix& M,
               const SparseCholesky& like);
  SignedFactor(const SignedFactor&) = delete;
  SignedFactor& operator=(const SignedFactor&) = delete;

  // False: a pivot vanished (sigma is an eigenvalue to round-off), or K or M has an entry that
  // `like` lacks.
  bool ok() const { return solve_ != nullptr; }
  Index n_negative() const { return n_negative_; }  // eigenvalues below sigma (Sylvester)
  // B <- (K - sigma M)^-1 B   (n x m)
  void solve_in_place(Eigen::Ref<Matrix> B);

 private:
  void rename(const SupernodalFactor& factor, const SignedPivots& pivots);

  std::vector<Index> px_, rows_, order_;
  Matrix x_;  // a column of all values
  SupernodeTree tree_;
  Index n_negative_ = -1;
  std::unique_ptr<SharedSolve> solve_;
};

}  // namespace cbr
