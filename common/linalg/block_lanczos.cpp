// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/block_lanczos.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// Not symmetric in any way, so that no eigenvector is orthogonal to it by the mesh's symmetry.
Matrix starting_block(Index n, Index columns) {
  Matrix X(n, columns);
  std::uint64_t state = 0x9E3779B97F4A7C15u;
  for (double& entry : X.reshaped()) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    entry = static_cast<double>(state >> 11) * 0x1p-53 - 0.5;
  }
  return X;
}

class BlockLanczos {
 public:
  BlockLanczos(const SparseMatrix& M, const std::function<void(Eigen::Ref<Matrix>)>& solve, Index k,
               const BlockLanczosOptions& options)
      : M_(M), solve_(solve), options_(options), n_(M.rows()), k_(k) {
    b_ = options.block > 0 ? options.block : std::clamp<Index>(k / 25, 4, 32);
    m_ = options.basis > 0 ? options.basis : std::max(2 * k, k + 6 * b_);
    m_ = (std::min(m_, n_ - b_) / b_) * b_;
  }

  Eigenpairs run(double sigma) {
    Eigenpairs pairs;
    pairs.method = "block lanczos";
    if (m_ < k_ + b_ || !start()) return pairs;
    for (pairs.iterations = 1; pairs.iterations <= options_.max_restarts; ++pairs.iterations) {
      if (!extend()) return pairs;
      rayleigh_ritz();
      pairs.n_converged = n_converged();
      if (pairs.n_converged >= k_) break;
      restart();
    }
    if (pairs.n_converged < k_) return pairs;
    pairs.converged = true;
    // OP x = theta x, theta = 1 / (lambda - sigma): the largest theta is the lowest lambda
    pairs.lambda = sigma + theta_.head(k_).cwiseInverse().array();
    pairs.Phi.noalias() = V_.leftCols(size_) * S_.leftCols(k_);
    return pairs;
  }

 private:
  // U <- U L^-T with U^T M U = L L^T, twice; R = the product of the factors' transposes. False when U is dependent.
  bool orthonormalise(Eigen::Ref<Matrix> U, Matrix& R) const {
    R = Matrix::Identity(U.cols(), U.cols());
    for (int pass = 0; pass < 2; ++pass) {
      const Matrix G = U.transpose() * Matrix(M_ * U);
      const Cholesky cholesky(G);
      if (!cholesky.ok()) return false;
      const Vector diagonal = cholesky.diagonal();
      if (!(diagonal.minCoeff() > 1e-7 * diagonal.maxCoeff())) return false;
      cholesky.divide_by_upper(U);
      R = cholesky.upper() * R;
    }
    return true;
  }

  bool start() {
    V_.resize(n_, m_ + b_);
    H_ = Matrix::Zero(m_, m_);
    size_ = 0;
    Matrix X = starting_block(n_, b_), R;
    // One application of the operator takes out most of what no wanted vector has.
    X = M_ * X;
    solve_(X);
    V_.leftCols(b_) = X;
    return orthonormalise(V_.leftCols(b_), R);
  }

  // Returns h = V^T M U of the first columns of V, U <- U - V h
  Matrix project_out(Eigen::Ref<Matrix> U, Index columns) const {
    const Matrix M_U = M_ * U;
    Matrix h = V_.leftCols(columns).transpose() * M_U;
    U.noalias() -= V_.leftCols(columns) * h;
    return h;
  }

  // Blocks until the basis has m vectors; V holds one block more.
  bool extend() {
    Matrix R, R_again;
    while (size_ < m_) {
      const Index columns = size_ + b_;
      auto next = V_.middleCols(columns, b_);
      next = M_ * V_.middleCols(size_, b_);
      solve_(next);
      // Twice, as orthonormalising enlarges the round-off that the first projection left.
      Matrix h = project_out(next, columns);
      if (!orthonormalise(next, R)) return false;
      h += project_out(next, columns) * R;
      if (!orthonormalise(next, R_again)) return false;
      last_ = R_again * R;
      H_.block(0, size_, columns, b_) = h;
      H_.block(size_, 0, b_, columns) = h.transpose();
      size_ = columns;
    }
    return true;
  }

  // H S = S diag(theta), theta descending
  void rayleigh_ritz() {
    const Matrix H = 0.5 * (H_ + H_.transpose());
    const Eigenpairs pairs = dense_eigenpairs(-H, Vector(Vector::Ones(m_)), m_);
    assert(pairs.converged);
    theta_ = -pairs.lambda;
    S_ = pairs.Phi;
  }

  // The residual of a Ritz pair is what the last block adds: R times the last rows of its vector.
  Index n_converged() const {
    const Vector residual = (last_ * S_.bottomRows(b_)).colwise().norm();
    const double round_off = std::numeric_limits<double>::epsilon() * std::max(options_.largest, std::abs(theta_(0)));
    Index count = 0;
    while (count < k_ && residual(count) <= std::max(options_.tolerance * std::abs(theta_(count)), round_off)) ++count;
    return count;
  }

  void restart() {
    // A third of the space above k goes on, as the pairs next in line help the last ones to converge.
    const Index kept = (std::min(m_ - 2 * b_, k_ + (m_ - k_) / 3) / b_) * b_;
    const Matrix Ritz = V_.leftCols(m_) * S_.leftCols(kept);
    V_.leftCols(kept) = Ritz;
    const Matrix next = V_.middleCols(m_, b_);
    V_.middleCols(kept, b_) = next;
    H_.setZero();
    H_.diagonal().head(kept) = theta_.head(kept);
    size_ = kept;
  }

  const SparseMatrix& M_;
  const std::function<void(Eigen::Ref<Matrix>)>& solve_;
  const BlockLanczosOptions& options_;
  Index n_ = 0, k_ = 0, b_ = 0, m_ = 0, size_ = 0;
  Matrix V_, H_, S_, last_;
  Vector theta_;
};

}  // namespace

Eigenpairs block_lanczos(const SparseMatrix& M, const std::function<void(Eigen::Ref<Matrix>)>& solve, double sigma, Index k,
                         const BlockLanczosOptions& options) {
  const double n = static_cast<double>(M.rows()), basis = 2 * static_cast<double>(k);
  const BlasForWork blas(4 * n * basis * basis);  // that keep it orthonormal
  return BlockLanczos(M, solve, k, options).run(sigma);
}

}  // namespace cbr
