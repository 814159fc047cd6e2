// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/eigen/lanczos_below.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/block_lanczos.hpp"

namespace cbr {
namespace {

// U <- U L^-T, P <- P L^-T with U^T P = L L^T (P = M U), twice; R = the product of the factors'
// transposes. False when U is dependent.
bool orthonormalise(Matrix& U, Matrix& P, Matrix& R) {
  R = Matrix::Identity(U.cols(), U.cols());
  for (int pass = 0; pass < 2; ++pass) {
    const Matrix G = U.transpose() * P;
    const Cholesky cholesky(0.5 * (G + G.transpose()));
    if (!cholesky.ok()) return false;
    const Vector diagonal = cholesky.diagonal();
    if (!(diagonal.minCoeff() > 1e-7 * diagonal.maxCoeff())) return false;
    cholesky.divide_by_upper(U);
    cholesky.divide_by_upper(P);
    R = cholesky.upper() * R;
  }
  return true;
}

// V^T M V = I and P = M V of the basis, H = V^T M K^-1 M V
struct Basis {
  // last: couples the newest block, which H does not have yet, to the one before
  Matrix V, P, H, last;
  Index size = 0;  // columns of V in H

  void reserve(Index n, Index columns) {
    V.conservativeResize(n, columns);
    P.conservativeResize(n, columns);
    H.conservativeResizeLike(Matrix::Zero(columns, columns));
  }
};

}  // namespace

Eigenpairs lanczos_below(Index n, Index n_rigid,
                         const std::function<Matrix(const Eigen::Ref<const Matrix>&)>& multiply_M,
                         const std::function<void(Eigen::Ref<Matrix>)>& solve, double bound,
                         const LanczosBelowOptions& options) {
  const Index b = options.block > 0 ? options.block : std::clamp<Index>(n / 60, 4, 16);
  const Index rank = n - n_rigid, whole = rank - 2 * b;
  const Index most = std::min(whole, options.most > 0 ? options.most : std::max<Index>(n / 4, 500));
  Eigenpairs pairs;
  pairs.method = "block lanczos";
  if (most < 2 * b) return pairs;
  Basis B;
  // One application of the operator damps unwanted eigenvectors.
  Matrix U = multiply_M(starting_block(n, b)), R, R_again;
  solve(U);
  Matrix P = multiply_M(U);
  if (!orthonormalise(U, P, R)) return pairs;
  Index look = std::min<Index>(most, 4 * b);
  for (;; ++pairs.iterations) {
    B.reserve(n, look + 2 * b);
    while (B.size < look) {
      B.V.middleCols(B.size, b) = U;
      B.P.middleCols(B.size, b) = P;
      const Index columns = B.size + b;
      const auto V = B.V.leftCols(columns), M_V = B.P.leftCols(columns);
      U = P;
      solve(U);
      Matrix h = M_V.transpose() * U;
      U.noalias() -= V * h;
      P = multiply_M(U);
      if (!orthonormalise(U, P, R)) return pairs;
      // Again, as orthonormalising enlarges the round-off that the first projection left.
      const Matrix rest = M_V.transpose() * U;
      U.noalias() -= V * rest;
      P.noalias() -= M_V * rest;
      h.noalias() += rest * R;
      if (!orthonormalise(U, P, R_again)) return pairs;
      B.last = R_again * R;
      B.H.block(0, B.size, columns, b) = h;
      B.H.block(B.size, 0, b, columns) = h.transpose();
      B.H.block(columns, B.size, b, b) = B.last;
      B.H.block(B.size, columns, b, b) = B.last.transpose();
      B.size = columns;
    }
    // H S = S diag(theta), theta descending; the last block gives the residual of a Ritz pair
    const Index m = B.size;
    const Matrix H = 0.5 * (B.H.topLeftCorner(m, m) + B.H.topLeftCorner(m, m).transpose());
    const Eigenpairs ritz = dense_eigenpairs(-H, Vector(Vector::Ones(m)), m);
    if (!ritz.converged) return pairs;
    const Vector residual = (B.last * ritz.Phi.bottomRows(b)).colwise().norm();
    const double round_off = std::numeric_limits<double>::epsilon() * std::abs(ritz.lambda(0));
    Index k = 0;
    while (k < m &&
           residual(k) <= std::max(options.tolerance * std::abs(ritz.lambda(k)), round_off))
      ++k;
    pairs.n_converged = k;
    const bool enough = options.count > 0 && k >= options.count;
    if (enough || (k > 0 && -1 / ritz.lambda(k - 1) > bound)) {
      pairs.converged = true;
      pairs.lambda = -ritz.lambda.head(k).cwiseInverse();
      pairs.Phi.noalias() = B.V.leftCols(m) * ritz.Phi.leftCols(k);
      return pairs;
    }
    if (look >= most) return pairs;
    look = std::min(most, look + std::max(2 * b, look / 4));
  }
}

}  // namespace cbr
