// SPDX-License-Identifier: GPL-3.0-or-later
// Shift-invert block Lanczos with thick restarts: sparse_eigenpairs() calls it, and who has a
// solution of their own.
#pragma once

#include <functional>
#include <optional>

#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {

// Starting block of Lanczos (n x columns). It has no symmetry, so that the mesh's symmetry makes no
// eigenvector orthogonal to it.
Matrix starting_block(Index n, Index columns);

struct BlockLanczosOptions {
  Index block = 0;  // 0: chosen from k
  Index basis = 0;  // vectors before a restart, 0: chosen from k and `bytes`
  // that the basis may take before its size has a restart, which takes more solves
  double bytes = 1e9;
  // Residual in the M-norm of a Ritz pair (theta, x) of (K - sigma M)^-1 M, relative to theta.
  // Pairs far below the largest theta (slender parts: 1e5 times) only reach its round-off, which
  // all pairs contain.
  double tolerance = 1e-13;
  Index max_restarts = 200;
  // Sigma lies inside the spectrum: the nearest on both sides are found, as many as make k, and at
  // least so many below and above.
  struct Inside {
    Index below = 0, above = 0;
  };
  std::optional<Inside> inside;
  // theta of `solve` itself, where the largest are taken out of it
  double largest = 0;
  // Told shares that never fall: how many looks at the basis there will be is guessed from how many
  // pairs have converged so far.
  Progress progress;
};

// P = M U   (n x m both)
using MassProduct = std::function<void(const Eigen::Ref<const Matrix>& U, Matrix& P)>;
MassProduct product_with(const SparseMatrix& M);  // of a matrix that outlives it

// The k eigenvalues of K x = lambda M x nearest above sigma. `inside`: nearest to it on both sides,
// ascending, and more than k where one side has too few. `solve` overwrites B (n x m) by (K - sigma
// M)^-1 B; where K is singular, of the elastic part alone, which excludes rigid motions. A block
// finds as many copies of a multiple eigenvalue as it has columns, by products of matrices.
// (Grimes, Lewis, Simon 1994, doi 10.1137/S0895479888151111; restarts: Wu, Simon 2000,
// doi 10.1137/S0895479898334605.) The basis is fully M-orthonormalised. converged: false when
// restarts ran out or a block became dependent. A block is dependent at an invariant subspace, as
// in a matrix with few distinct eigenvalues: use another method. Phi comes without fixed signs.
Eigenpairs block_lanczos(Index n, const MassProduct& times_M,
                         const std::function<void(Eigen::Ref<Matrix>)>& solve, double sigma,
                         Index k, const BlockLanczosOptions& options = {});

}  // namespace cbr
