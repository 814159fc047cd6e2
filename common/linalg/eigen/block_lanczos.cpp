// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/eigen/block_lanczos.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/tall_basis.hpp"

namespace cbr {

Matrix starting_block(Index n, Index columns) {
  Matrix X(n, columns);
  std::uint64_t state = 0x9E3779B97F4A7C15u;
  for (double& entry : X.reshaped()) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    entry = static_cast<double>(state >> 11) * 0x1p-53 - 0.5;
  }
  return X;
}

namespace {

// Up to this tolerance Ritz vectors are eigenvectors to about round-off.
constexpr double to_round_off = 1e-9;
// Of a block to those before it: below, the space loses nothing to modes that only make a basis.
constexpr double still_orthogonal = 1e-8;

class BlockLanczos {
 public:
  BlockLanczos(Index n, const MassProduct& times_M,
               const std::function<void(Eigen::Ref<Matrix>)>& solve, Index k,
               const BlockLanczosOptions& options)
      : times_M_(times_M),
        solve_(solve),
        options_(options),
        n_(n),
        k_(k),
        b_(options.block > 0 ? options.block : chosen_block(n, k)),
        m_(largest_basis()),
        may_skip_(options.tolerance > to_round_off),
        V_(n_, b_, m_ + b_) {}

  Eigenpairs run(double sigma) {
    sigma_ = sigma;
    Eigenpairs pairs;
    pairs.method = "block lanczos";
    if (m_ < k_ + b_ || !start()) return pairs;
    Index look = first_look();
    while (true) {
      if (!extend(look)) return pairs;
      rayleigh_ritz();
      pairs.n_converged = n_converged();
      if (pairs.n_converged >= goal_) break;
      expect_looks(pairs.n_converged);
      if (size_ < m_) {
        look = next_look(pairs.n_converged);
        continue;
      }
      if (pairs.iterations == options_.max_restarts) return pairs;
      restart();
      ++pairs.iterations;
      look = m_;
    }
    pairs.converged = true;
    if (options_.inside) put_in_order();
    // OP x = theta x, theta = 1 / (lambda - sigma): the largest theta is the lowest lambda
    pairs.lambda = theta_.head(goal_).cwiseInverse();
    Matrix S = S_.leftCols(goal_);
    if (options_.tolerance > to_round_off) iterate_once(pairs.lambda, S);
    pairs.lambda.array() += sigma_;
    const SingleThreadedBlas blas;
    pairs.Phi = V_.combined(S);
    return pairs;
  }

 private:
  // Wide enough to read a factor once for many, narrow enough for a space of many powers.
  static Index chosen_block(Index n, Index k) {
    const Index wide = k < 400 ? 8 : 16;
    return std::min(wide, std::max<Index>(4, n / 40));
  }

  Index whole_blocks(Index vectors) const { return vectors / b_ * b_; }

  // Vectors before a restart. Without one the space needs some 2 k and a few blocks.
  Index largest_basis() const {
    Index most = options_.basis;
    if (most == 0) {
      const auto in_memory =
          static_cast<Index>(options_.bytes / (8 * static_cast<double>(std::max<Index>(n_, 1))));
      most = std::clamp(in_memory, std::max(2 * k_, k_ + 6 * b_), 4 * k_ + 24 * b_);
    }
    return whole_blocks(std::min(most, n_ - b_));
  }

  // Of pairs that are nearest on both sides, ascending in lambda.
  void put_in_order() {
    std::vector<Index> order = first_numbers(goal_);
    std::sort(order.begin(), order.end(),
              [&](Index i, Index j) { return 1 / theta_(i) < 1 / theta_(j); });
    theta_ = Vector(theta_(order));
    S_ = Matrix(S_(Eigen::all, order));
  }

  // A step takes half a digit to a whole one from the residuals, once the space holds the wanted
  // vectors in outline.
  Index first_look() const {
    if (options_.inside) return std::min(m_, whole_blocks(5 * k_ / 2 + 4 * b_));
    const auto last_digits = static_cast<double>((k_ < 64 ? 12 : 24) * b_);
    const double digits = std::clamp(-std::log10(options_.tolerance), 0.0, 13.0);
    return std::min(m_,
                    whole_blocks(5 * k_ / 2 + static_cast<Index>(last_digits * (0.08 * digits))));
  }

  // Ritz pairs converge at about the rate at which they did so far; looks cost an eigenvalue
  // problem each.
  Index next_look(Index converged) const {
    if (options_.inside) return std::min(m_, size_ + std::max(b_, whole_blocks(vectors_missing())));
    const Index missing = 2 * (goal_ - converged);
    return std::min(m_, size_ + std::max(2 * b_, whole_blocks(std::min(missing, size_ / 6))));
  }

  // The worst residual falls by about as many digits with each vector as it has since the last
  // look.
  Index vectors_missing() const {
    const double most = static_cast<double>(size_) / 6;
    const double digits = std::log10(worst_before_ / worst_);
    if (!(digits > 0.5)) return static_cast<Index>(most);
    const double missing = std::log10(worst_ / options_.tolerance);
    return static_cast<Index>(
        std::clamp(missing / digits * static_cast<double>(size_ - size_before_), 0.0, most));
  }

  // Fraction of the work at the next check, if missing pairs converge at the pace so far.
  void expect_looks(Index converged) {
    constexpr double most_looks = 12;
    const double gained = std::max<double>(1, static_cast<double>(converged - n_converged_)),
                 missing = static_cast<double>(goal_ - converged);
    n_converged_ = converged;
    share_ = next_share_;
    next_share_ += (1 - share_) / std::clamp(missing / gained + 1, 1.5, most_looks);
  }

  // U <- U L^-T with U^T P = L L^T (P = M U), and R = L^T. False when U is dependent.
  bool orthonormalise_once(Eigen::Ref<Matrix> U, const Matrix& P, Matrix& R) {
    const Matrix G = tall_product(U, P);
    const Cholesky cholesky(Matrix(0.5 * (G + G.transpose())));
    if (!cholesky.ok()) return false;
    const Vector diagonal = cholesky.diagonal();
    if (!(diagonal.minCoeff() > 1e-7 * diagonal.maxCoeff())) return false;
    R = cholesky.upper();
    // L is as small as a block is wide, and so well-conditioned that its inverse will do
    inverse_.setIdentity(U.cols(), U.cols());
    cholesky.divide_by_upper(inverse_);
    multiply_on_right(inverse_, U);
    return true;
  }

  // Whether U has kept its digits in orthonormalise_once().
  static bool is_even(const Matrix& R) {
    return R.diagonal().minCoeff() > 1e-3 * R.diagonal().maxCoeff();
  }

  // The same, and P <- P L^-T
  bool orthonormalise_both(Eigen::Ref<Matrix> U, Matrix& P, Matrix& R) {
    if (!orthonormalise_once(U, P, R)) return false;
    multiply_on_right(inverse_, P);
    return true;
  }

  // Twice; P = M U afterwards to round-off.
  bool orthonormalise(Eigen::Ref<Matrix> U, Matrix& P, Matrix& R) {
    Matrix R_1, R_2;
    if (!orthonormalise_once(U, P, R_1)) return false;
    times_M_(U, P);
    if (!orthonormalise_both(U, P, R_2)) return false;
    R = R_2 * R_1;
    return true;
  }

  bool start() {
    const SingleThreadedBlas blas;
    H_ = Matrix::Zero(m_, m_);
    size_ = 0;
    // One application of the operator damps unwanted eigenvectors.
    Matrix X, R;
    times_M_(starting_block(n_, b_), X);
    auto first = V_.block(0);
    first = X;
    solve_(first);
    times_M_(first, P_);
    return orthonormalise(first, P_, R);
  }

  // Blocks until the basis has so many vectors; V holds one block more, and P is M times that one.
  bool extend(Index vectors) {
    size_before_ = size_;
    const SingleThreadedBlas blas;
    const auto begin = static_cast<double>(size_), more = static_cast<double>(vectors) - begin;
    while (size_ < vectors) {
      const Index columns = size_ + b_;
      auto U = V_.block(columns);
      U = P_;
      solve_(U);
      Matrix h;
      if (is_restarted_) {
        // All that was kept couples with this block
        times_M_(U, P_);
        h = V_.transposed_product(columns, P_);
        V_.subtract(h, U);
        times_M_(U, P_);
        is_restarted_ = false;
      } else {
        h = three_terms(U);
      }
      Matrix R, R_again;
      if (!orthonormalise_once(U, P_, R)) return false;
      if (skips_ && is_even(R)) {
        multiply_on_right(inverse_, P_);
      } else {
        times_M_(U, P_);
      }
      // Against all, as orthonormalising enlarges the round-off that was left
      if (!skips_) {
        const Matrix rest = V_.transposed_product(columns, P_);
        V_.subtract(rest, U);
        h += rest * R;
        times_M_(U, P_);
        may_skip_ = may_skip_ && rest.cwiseAbs().maxCoeff() < still_orthogonal;
      }
      // What a block has of the last but one it passes on as it is, what it has of the last grown
      // by theta_1 / theta of the newest: so the next but one need not be looked at
      skips_ = may_skip_ && !skips_;
      // U was orthonormal before the last subtraction, up to round-off: once is enough
      if (!orthonormalise_both(U, P_, R_again)) return false;
      last_ = R_again * R;
      H_.block(0, size_, columns, b_) = h;
      H_.block(size_, 0, b_, columns) = h.transpose();
      size_ = columns;
      if (options_.progress)
        options_.progress(share_ + (next_share_ - share_) *
                                       std::min(1.0, (static_cast<double>(size_) - begin) / more));
    }
    return true;
  }

  // U <- U - V_j (V_j^T M U) - V_j-1 (V_j-1^T M U) of the last two blocks; components along the
  // others are round-off. P_: M V_j, then M U.
  Matrix three_terms(Eigen::Ref<Matrix> U) {
    Matrix h = Matrix::Zero(size_ + b_, b_);
    const Matrix own = tall_product(P_, U);
    h.bottomRows(b_) = 0.5 * (own + own.transpose());
    const auto newest = V_.block(size_);
    subtract_product(newest, h.bottomRows(b_), U);
    if (size_ > 0) {
      h.middleRows(size_ - b_, b_) = last_.transpose();
      subtract_product(V_.block(size_ - b_), last_.transpose(), U);
    }
    times_M_(U, P_);
    return h;
  }

  // H S = S diag(theta), theta descending
  void rayleigh_ritz() {
    goal_ = k_;
    if (options_.inside) return rayleigh_ritz_inside();
    const auto H = H_.topLeftCorner(size_, size_);
    // A restart keeps a third of the vectors beyond k
    const Index wanted = size_ < m_ ? k_ : kept();
    const Eigenpairs pairs =
        dense_eigenpairs(-0.5 * (H + H.transpose()), Vector(Vector::Ones(size_)), wanted);
    assert(pairs.converged);
    theta_ = -pairs.lambda;
    S_ = pairs.Phi;
  }

  // The same, |theta| descending.
  void rayleigh_ritz_inside() {
    const auto H = H_.topLeftCorner(size_, size_);
    const Eigenpairs pairs = dense_eigenpairs(0.5 * (H + H.transpose()), size_);
    assert(pairs.converged);
    std::vector<Index> order = first_numbers(size_);
    std::sort(order.begin(), order.end(), [&](Index i, Index j) {
      return std::abs(pairs.lambda(i)) > std::abs(pairs.lambda(j));
    });
    Index below = 0, above = 0;
    const auto is_short = [&](Index pair) {
      return pair < k_ || below < options_.inside->below || above < options_.inside->above;
    };
    for (goal_ = 0; goal_ < size_ && is_short(goal_); ++goal_)
      ++(pairs.lambda(order[goal_]) < 0 ? below : above);
    order.resize(size_ < m_ ? goal_ : std::max(goal_, kept()));
    theta_ = pairs.lambda(order);
    S_ = pairs.Phi(Eigen::all, order);
  }

  // The space of OP X, X the Ritz vectors, holds less of the higher eigenvectors. By OP X = X
  // diag(theta) + V_next E it has x = X + V_next E diag(theta)^-1, where x^T (K - sigma M) x is
  // diag(theta)^-1. lambda, S: of X, then of the Ritz vectors of K in that space, the rows of
  // V_next behind.
  void iterate_once(Vector& lambda, Matrix& S) const {
    const Matrix E = last_ * S.bottomRows(b_) * lambda.asDiagonal();
    Matrix mass = E.transpose() * E;
    mass.diagonal().array() += 1;
    const Eigenpairs pairs = dense_eigenpairs(Matrix(lambda.asDiagonal()), mass, goal_);
    assert(pairs.converged);
    lambda = pairs.lambda;
    Matrix both(size_ + b_, goal_);
    both << S * pairs.Phi, E * pairs.Phi;
    S = std::move(both);
  }

  // The last block gives the residual of a Ritz pair: R times the last rows of its vector.
  Index n_converged() {
    const Vector residual = (last_ * S_.bottomRows(b_)).colwise().norm();
    // Solves with a shift inside the spectrum lose a little more
    const double lost = options_.inside ? 16 : 1;
    const double round_off = lost * std::numeric_limits<double>::epsilon() *
                             std::max(options_.largest, std::abs(theta_(0)));
    const auto is_within = [&](Index pair) {
      return residual(pair) <= std::max(options_.tolerance * std::abs(theta_(pair)), round_off);
    };
    worst_before_ = std::exchange(
        worst_, (residual.head(goal_).array() / theta_.head(goal_).array().abs()).maxCoeff());
    Index count = 0;
    while (count < goal_ && is_within(count)) ++count;
    return count;
  }

  // A third of the space above k goes on, as the pairs next in line help the last ones to converge.
  Index kept() const { return whole_blocks(std::min(m_ - 2 * b_, goal_ + (m_ - goal_) / 3)); }

  void restart() {
    const SingleThreadedBlas blas;
    const Index kept = this->kept();
    V_.rotate(S_.leftCols(kept));
    const Matrix next = V_.block(m_);
    V_.block(kept) = next;
    H_.setZero();
    H_.diagonal().head(kept) = theta_.head(kept);
    size_ = kept;
    is_restarted_ = true;
    skips_ = false;
  }

  const MassProduct& times_M_;
  const std::function<void(Eigen::Ref<Matrix>)>& solve_;
  const BlockLanczosOptions& options_;
  Index goal_ = 0;  // pairs that must converge: k, or more of those inside the spectrum
  Index n_ = 0, k_ = 0, b_ = 0, m_ = 0, size_ = 0;
  // Whether every other block, and whether the next one, need not be made orthogonal to all.
  bool may_skip_ = false, skips_ = false;
  Index n_converged_ = 0;
  double share_ = 0, next_share_ = 0.8;  // of the work: at the last look, and at the next one
  double sigma_ = 0;
  // The largest relative residual, at the last two looks
  double worst_ = HUGE_VAL, worst_before_ = HUGE_VAL;
  Index size_before_ = 0;
  TallBasis V_;
  Matrix P_, H_, S_, last_, inverse_;
  Vector theta_;
  bool is_restarted_ = false;
};

}  // namespace

MassProduct product_with(const SparseMatrix& M) {
  return [&M](const Eigen::Ref<const Matrix>& U, Matrix& P) { multiply_symmetric(M, U, P); };
}

Eigenpairs block_lanczos(Index n, const MassProduct& times_M,
                         const std::function<void(Eigen::Ref<Matrix>)>& solve, double sigma,
                         Index k, const BlockLanczosOptions& options) {
  return BlockLanczos(n, times_M, solve, k, options).run(sigma);
}

}  // namespace cbr
