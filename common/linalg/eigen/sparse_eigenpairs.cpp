// SPDX-License-Identifier: GPL-3.0-or-later
#include <arpack.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <mutex>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/block_lanczos.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/linalg/eigen/spectrum_slices.hpp"
#include "common/linalg/eigen/tall_basis.hpp"
#include "common/linalg/sparse/fronts.hpp"

namespace cbr {
namespace {

constexpr Index max_restarts = 1000;
constexpr double orthonormality = 1e-13;
// Of slices, whose vectors are orthogonal to their residuals, and of few pairs, which cost little.
constexpr double least_tolerance = 1e-13;
// From here on blocks win (docs/decisions/eigen-crossover.md).
constexpr Index least_for_blocks = 10;

// Operators of ARPACK's reverse communication, as two functions of n-vectors. Its mode 3:
// (K - sigma M)^-1 M x.
struct Operator {
  Index n = 0;
  double sigma = 0;
  std::function<void(const double* x, double* y)> solve;     // y = (K - sigma M)^-1 x
  std::function<void(const double* x, double* y)> multiply;  // y = M x
};
constexpr a_int shift_invert = 3;
constexpr const char *generalised = "G", *nearest = "LM";

struct Ritz {
  Vector value;
  Matrix vectors;
  Index n_converged = 0, restarts = 0;
};

// ARPACK keeps its state in static variables.
std::mutex& arpack_lock() {
  static std::mutex lock;
  return lock;
}

class Arpack {
 public:
  Arpack(const Operator& op, Index k, Index ncv, double tolerance)
      : op_(op),
        n_(static_cast<a_int>(op.n)),
        k_(static_cast<a_int>(k)),
        ncv_(static_cast<a_int>(ncv)),
        tolerance_(tolerance),
        residual_(starting_block(op.n, 1)),
        V_(op.n, ncv),
        workd_(3 * op.n),
        workl_(ncv * (ncv + 8)),
        scratch_(op.n) {
    iparam_[0] = 1;  // exact shifts
    iparam_[2] = static_cast<a_int>(max_restarts);
    iparam_[3] = 1;
    iparam_[6] = shift_invert;
  }

  Ritz run() {
    a_int ido = 0, info = 1;
    const auto lworkl = static_cast<a_int>(workl_.size());
    while (true) {
      dsaupd_c(&ido, generalised, n_, nearest, k_, tolerance_, residual_.data(), ncv_, V_.data(),
               n_, iparam_.data(), ipntr_.data(), workd_.data(), workl_.data(), lworkl, &info);
      if (ido == 99) break;
      answer(ido);
    }
    // 1: too many restarts, 3: no shifts could be applied; pairs that converged by then are
    // returned.
    if (info < 0)
      throw RunError("eigensolver ARPACK dsaupd failed with code " + std::to_string(info));
    return extract();
  }

 private:
  void answer(a_int ido) {
    const double* x = workd_.data() + ipntr_[0] - 1;
    double* y = workd_.data() + ipntr_[1] - 1;
    if (ido == 2) {
      op_.multiply(x, y);
    } else if (ido == 1) {
      op_.solve(workd_.data() + ipntr_[2] - 1, y);
    } else {
      op_.multiply(x, scratch_.data());
      op_.solve(scratch_.data(), y);
    }
  }

  Ritz extract() {
    Ritz ritz;
    ritz.n_converged = iparam_[4];
    ritz.restarts = iparam_[2];
    if (ritz.n_converged == 0) return ritz;
    std::vector<a_int> select(ncv_, 1);
    ritz.value.resize(k_);
    a_int info = 0;
    // The vectors take the place of the first columns of V.
    dseupd_c(1, "A", select.data(), ritz.value.data(), V_.data(), n_, op_.sigma, generalised, n_,
             nearest, k_, tolerance_, residual_.data(), ncv_, V_.data(), n_, iparam_.data(),
             ipntr_.data(), workd_.data(), workl_.data(), static_cast<a_int>(workl_.size()), &info);
    if (info != 0)
      throw RunError("eigensolver ARPACK dseupd failed with code " + std::to_string(info));
    ritz.n_converged = std::min<Index>(iparam_[4], k_);
    ritz.value.conservativeResize(ritz.n_converged);
    V_.conservativeResize(Eigen::NoChange, ritz.n_converged);
    ritz.vectors = std::move(V_);
    return ritz;
  }

  const Operator& op_;
  a_int n_, k_, ncv_;
  double tolerance_;
  std::array<a_int, 11> iparam_{}, ipntr_{};
  Vector residual_;
  Matrix V_;
  Vector workd_, workl_, scratch_;
};

Eigenpairs ascending(Ritz&& ritz) {
  std::vector<Index> order = first_numbers(ritz.value.size());
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return ritz.value(a) < ritz.value(b); });
  Eigenpairs pairs;
  pairs.lambda = ritz.value(order);
  pairs.Phi = ritz.vectors(Eigen::all, order);
  return pairs;
}

// Gram matrix G = Phi^T M Phi = L L^T, Phi <- Phi L^-T: keeps the order, because L is the identity
// to ARPACK's accuracy.
void orthonormalise(const SparseMatrix& M, Matrix& Phi) {
  for (int pass = 0; pass < 3; ++pass) {
    Matrix M_Phi;
    multiply_symmetric(M, Phi, M_Phi);
    const Matrix G = Phi.transpose() * M_Phi;
    const double error = (G - Matrix::Identity(G.rows(), G.cols())).cwiseAbs().maxCoeff();
    if (error < orthonormality) return;
    const Cholesky cholesky(G);
    // seen by the caller's own check; cannot happen with converged vectors
    if (!cholesky.ok()) return;
    cholesky.divide_by_upper(Phi);
  }
}

Eigenpairs finished(const SparseMatrix& M, Eigenpairs&& pairs) {
  orthonormalise(M, pairs.Phi);
  fix_signs(pairs.Phi);
  return std::move(pairs);
}

// Columns that a product with K takes together: more would not stay in the cache.
constexpr std::ptrdiff_t at_a_time = 32;

// Where the spectrum is wide, 1 / theta has more of the largest theta's round-off than Rayleigh's
// quotient has of K's.
void sharpen(const SparseMatrix& K, const SparseMatrix& M, Eigenpairs& pairs) {
  const double scale = (K.diagonal().array() / M.diagonal().array()).maxCoeff(),
               lowest = pairs.lambda(0);
  std::vector<Index> blurred;
  for (Index j = 0; j < pairs.lambda.size(); ++j)
    if (pairs.lambda(j) * pairs.lambda(j) / lowest > 10 * scale) blurred.push_back(j);
  const auto quotients = [&](const std::vector<Index>& columns) {
    const Matrix Phi = pairs.Phi(Eigen::all, columns);
    Matrix K_Phi;
    multiply_symmetric(K, Phi, K_Phi);
    for (std::size_t i = 0; i < columns.size(); ++i)
      pairs.lambda(columns[i]) =
          Phi.col(static_cast<Index>(i)).dot(K_Phi.col(static_cast<Index>(i)));
  };
  for (auto first = blurred.begin(); first < blurred.end();) {
    const auto end = std::min(first + at_a_time, blurred.end());
    quotients({first, end});
    first = end;
  }
  // Equal frequencies may change places by round-off.
  if (std::is_sorted(pairs.lambda.begin(), pairs.lambda.end())) return;
  std::vector<Index> order = order_by(
      pairs.lambda.size(), [&](Index a, Index b) { return pairs.lambda(a) < pairs.lambda(b); });
  pairs.lambda = Vector(pairs.lambda(order));
  pairs.Phi = Matrix(pairs.Phi(Eigen::all, order));
}

Eigenpairs dense_answer(const SparseMatrix& K, const SparseMatrix& M, Index k) {
  bool diagonal = true;
  for (Index j = 0; diagonal && j < M.cols(); ++j) {
    for (SparseMatrix::InnerIterator it(M, j); it; ++it)
      diagonal = diagonal && (it.row() == j || it.value() == 0);
  }
  if (diagonal) return dense_eigenpairs(Matrix(K), Vector(M.diagonal()), k);
  return dense_eigenpairs(Matrix(K), Matrix(M), k);
}

// Half of the factor's bytes, as a solve reads all of them, but at most a quarter of the memory
// beside it.
double bytes_of_basis(const SparseCholesky& factor) {
  return std::max(1e9,
                  std::min(0.5 * factor.bytes(), 0.25 * (machine_memory_bytes() - factor.bytes())));
}

// Two factors and the fronts of the second.
bool slices_fit(const SparseCholesky& factor, Index k, Index width) {
  const double vectors = static_cast<double>(k + 6 * width) * static_cast<double>(factor.n_rows());
  return 2 * factor.bytes() + front_bytes(factor.tree()) + 8 * vectors <
         0.7 * machine_memory_bytes();
}

}  // namespace

void fix_signs(Matrix& Phi) {
  for (Index j = 0; j < Phi.cols(); ++j) {
    auto column = Phi.col(j);
    if (column.size() == 0) continue;
    // Symmetric shapes have several largest entries that differ by round-off: the first of them
    // decides.
    const double limit = (1 - 1e-6) * column.cwiseAbs().maxCoeff();
    for (const double entry : column) {
      if (std::abs(entry) < limit) continue;
      if (entry < 0) column = -column;
      break;
    }
  }
}

Eigenpairs sparse_eigenpairs(const SparseMatrix& K, const SparseMatrix& M,
                             const SparseCholesky& factor, double sigma, Index k, double tolerance,
                             Index ncv, const Progress& progress) {
  const Index n = K.rows();
  assert(k >= 0 && k <= n && M.rows() == n);
  Eigenpairs pairs;
  if (k == 0) {
    pairs.Phi.resize(n, 0);
    pairs.converged = true;
    pairs.method = "none";
    return pairs;
  }
  if (n <= 40 || k > n / 2) return dense_answer(K, M, k);
  assert(factor.ok() && factor.n_rows() == n);
  if (k >= least_for_blocks && ncv == 0) {
    BlockLanczosOptions options;
    options.tolerance = tolerance;
    options.bytes = bytes_of_basis(factor);
    options.progress = progress;
    const Index width = slice_width(n, factor.flops());
    if (sigma == 0 && slices_pay(k, width, tolerance > least_tolerance) &&
        slices_fit(factor, k, width))
      pairs = eigenpairs_by_slices(K, M, factor, k, width, least_tolerance, progress);
    if (!pairs.converged)
      pairs = block_lanczos(
          n, product_with(M), [&](Eigen::Ref<Matrix> B) { factor.solve_in_place(B); }, sigma, k,
          options);
    if (pairs.converged) {
      pairs = finished(M, std::move(pairs));
      sharpen(K, M, pairs);
      return pairs;
    }
  }
  if (ncv == 0) ncv = std::max<Index>(2 * k + 1, 20);
  ncv = std::clamp(ncv, k + 1, n);

  Operator op;
  op.n = n;
  op.sigma = sigma;
  op.solve = [&](const double* x, double* y) { factor.solve(x, y); };
  op.multiply = [&](const double* x, double* y) {
    Eigen::Map<Vector>(y, n).noalias() =
        M.selfadjointView<Eigen::Lower>() * Eigen::Map<const Vector>(x, n);
  };
  const std::scoped_lock lock(arpack_lock());
  const SingleThreadedBlas blas;  // vectors and triangular solves: memory is the limit
  Ritz ritz = Arpack(op, k, ncv, least_tolerance).run();
  const Index n_converged = ritz.n_converged, restarts = ritz.restarts;
  pairs = ascending(std::move(ritz));
  pairs.n_converged = n_converged;
  pairs.iterations = restarts;
  pairs.converged = n_converged >= k;
  pairs.method = "arpack";
  return finished(M, std::move(pairs));
}

Eigenpairs sparse_eigenpairs_beyond(const SparseMatrix& M, const SparseCholesky& factor,
                                    const Matrix& Phi, Index k, double tolerance,
                                    const Progress& progress) {
  assert(Phi.rows() == M.rows() && k > 0);
  const auto project = [&](Eigen::Ref<Matrix> B) {
    const Matrix M_B = M * B;
    B.noalias() -= Phi * (Phi.transpose() * M_B);
  };
  BlockLanczosOptions options;
  options.tolerance = tolerance;
  options.bytes = bytes_of_basis(factor);
  options.progress = progress;
  if (Phi.cols() > 0) {
    const Vector M_phi = M * Phi.col(0);
    Vector x(M_phi.size());
    factor.solve(M_phi.data(), x.data());
    options.largest = M_phi.dot(x);  // 1 / lambda_1
  }
  // P K^-1 with P = I - Phi Phi^T M: known eigenvectors have the eigenvalue 0 there, the farthest
  // from the wanted ones
  Eigenpairs pairs = block_lanczos(
      M.rows(), product_with(M),
      [&](Eigen::Ref<Matrix> B) {
        factor.solve_in_place(B);
        project(B);
      },
      0, k, options);
  if (!pairs.converged) return pairs;
  project(pairs.Phi);
  return finished(M, std::move(pairs));
}

Eigenpairs sparse_eigenpairs_onwards(const SparseMatrix& K, const SparseMatrix& M,
                                     const SparseCholesky& factor, const Eigenpairs& known, Index k,
                                     double tolerance, const Progress& progress) {
  const Index width = slice_width(K.rows(), factor.flops()), more = k - known.lambda.size();
  Eigenpairs pairs;
  // One shift more costs a factorisation
  if (2 * more < width || !slices_fit(factor, k, width)) return pairs;
  pairs = eigenpairs_by_slices(K, M, factor, k, width, tolerance, progress, known);
  if (!pairs.converged) return pairs;
  pairs = finished(M, std::move(pairs));
  sharpen(K, M, pairs);
  return pairs;
}

}  // namespace cbr
