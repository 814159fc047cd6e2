// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/dense.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <lapacke.h>

#include <algorithm>
#include <utility>

#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/lower_updates.hpp"

namespace cbr {
namespace {

// Rows from which on LAPACK's factorisation, in blocks that it halves, is the faster one.
constexpr Index worth_lapack = 256;

// Flops of a solution from which on our threads share its columns.
constexpr double worth_sharing = 2e8;

double product_of(Index a, Index b, Index c) {
  return static_cast<double>(a) * static_cast<double>(b) * static_cast<double>(c);
}

// work(first, count) for parts of n columns or rows, on our threads with a BLAS of one thread each
// where that is worth it.
template <typename Work>
void share_parts(Index n, double flops, const Work& work) {
  const Index parts = flops < worth_sharing ? 1 : std::min<Index>(n_threads(), n);
  if (parts <= 1) return work(0, n);
  const SingleThreadedBlas blas;
  run_kept_threads(static_cast<int>(parts), [&](int part) {
    const Index first = n * part / parts;
    work(first, n * (part + 1) / parts - first);
  });
}

}  // namespace

Cholesky::Cholesky(Matrix A) : L_(std::move(A)), ok_(cholesky_in_place(L_)) {}

Matrix Cholesky::lower() const { return L_.triangularView<Eigen::Lower>(); }
Matrix Cholesky::upper() const { return L_.adjoint().triangularView<Eigen::Upper>(); }

void Cholesky::solve_in_place(Vector& x) const {
  L_.triangularView<Eigen::Lower>().solveInPlace(x);
  L_.adjoint().triangularView<Eigen::Upper>().solveInPlace(x);
}

void Cholesky::solve_in_place(Eigen::Ref<Matrix> X) const {
  share_parts(X.cols(), 2 * product_of(L_.rows(), L_.rows(), X.cols()),
              [&](Index first, Index count) {
                auto part = X.middleCols(first, count);
                L_.triangularView<Eigen::Lower>().solveInPlace(part);
                L_.adjoint().triangularView<Eigen::Upper>().solveInPlace(part);
              });
}

void Cholesky::solve_lower_in_place(Eigen::Ref<Matrix> X) const {
  share_parts(X.cols(), product_of(L_.rows(), L_.rows(), X.cols()), [&](Index first, Index count) {
    auto part = X.middleCols(first, count);
    L_.triangularView<Eigen::Lower>().solveInPlace(part);
  });
}

void Cholesky::solve_upper_in_place(Eigen::Ref<Matrix> X) const {
  share_parts(X.cols(), product_of(L_.rows(), L_.rows(), X.cols()), [&](Index first, Index count) {
    auto part = X.middleCols(first, count);
    L_.adjoint().triangularView<Eigen::Upper>().solveInPlace(part);
  });
}

void Cholesky::divide_by_upper(Eigen::Ref<Matrix> X) const { cbr::divide_by_upper(L_, X); }
Matrix Cholesky::times_upper(const Matrix& B) const {
  return L_.adjoint().triangularView<Eigen::Upper>() * B;
}

void Cholesky::divide_both_sides(Matrix& A) const {
  if (A.rows() == 0) return;
  const SingleThreadedBlas blas;
  cbr::divide_both_sides(L_, A);
}

bool cholesky_in_place(Eigen::Ref<Matrix> A) {
  bool ok = false;
  if (A.rows() < worth_lapack) {
    ok = Eigen::LLT<Eigen::Ref<Matrix>>(A).info() == Eigen::Success;
  } else if (A.rows() < worth_tiles) {
    ok = LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', static_cast<int>(A.rows()), A.data(),
                             static_cast<int>(A.outerStride())) == 0;
  } else {
    const SingleThreadedBlas blas;
    ok = factor_columns(A);
  }
  // A NaN is no pivot that any of them refuses; it reaches the diagonal of its row
  return ok && A.diagonal().allFinite();
}

void divide_by_upper(const Matrix& L, Eigen::Ref<Matrix> X) {
  share_parts(X.rows(), product_of(L.rows(), L.rows(), X.rows()), [&](Index first, Index count) {
    auto part = X.middleRows(first, count);
    L.adjoint().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(part);
  });
}

std::optional<Matrix6> small_cholesky(const Matrix6& A) {
  const Eigen::LLT<Matrix6> factor(A);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return Matrix6(factor.matrixL());
}

Ldlt::Ldlt(const Matrix& A) : factor_(std::make_shared<const Eigen::LDLT<Matrix>>(A)) {}
Vector Ldlt::solve_vector(const Vector& b) const { return factor_->solve(b); }
Matrix Ldlt::solve_matrix(const Matrix& B) const { return factor_->solve(B); }

Vector3 solve_symmetric(const Matrix3& A, const Vector3& b) { return A.ldlt().solve(b); }

std::optional<Vector3> solve_semidefinite(const Matrix3& A, const Vector3& b) {
  const Eigen::LDLT<Matrix3> factor(A);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
  return Vector3(factor.solve(b));
}

Lu::Lu(Matrix A) {
  auto factor = std::make_shared<Eigen::PartialPivLU<Matrix>>();
  factor->compute(std::move(A));
  factor_ = std::move(factor);
}
double Lu::smallest_pivot() const { return factor_->matrixLU().diagonal().cwiseAbs().minCoeff(); }
Matrix Lu::inverse() const { return factor_->inverse(); }
Vector Lu::solve_vector(const Vector& b) const { return factor_->solve(b); }
Matrix Lu::solve_matrix(const Matrix& B) const { return factor_->solve(B); }

Matrix null_space(const Matrix& A, double threshold) {
  Eigen::FullPivLU<Matrix> lu(A);
  lu.setThreshold(threshold);
  if (lu.dimensionOfKernel() == 0) return Matrix(A.cols(), 0);
  return lu.kernel();
}

Reflections householder_reflections(const Matrix& A) {
  const Eigen::HouseholderQR<Matrix> qr(A);
  return {qr.matrixQR(), qr.hCoeffs()};
}

Matrix orthonormal_basis(const Matrix& A) {
  return Eigen::HouseholderQR<Matrix>(A).householderQ() * Matrix::Identity(A.rows(), A.cols());
}

Matrix3 orthonormal_axes(const Matrix& A) { return Eigen::HouseholderQR<Matrix>(A).householderQ(); }

PivotedQr::PivotedQr(const Matrix& A)
    : factor_(std::make_shared<const Eigen::ColPivHouseholderQR<Matrix>>(A)) {}

PivotedQr::PivotedQr(const Matrix& A, double threshold) {
  auto factor = std::make_shared<Eigen::ColPivHouseholderQR<Matrix>>(A);
  factor->setThreshold(threshold);
  factor_ = std::move(factor);
}

Index PivotedQr::rank() const { return factor_->rank(); }
Index PivotedQr::column(Index j) const { return factor_->colsPermutation().indices()(j); }
Matrix PivotedQr::Q() const {
  const Index m = factor_->rows();
  return factor_->householderQ() * Matrix::Identity(m, m);
}
Matrix3 PivotedQr::axes() const { return factor_->householderQ(); }
Vector PivotedQr::solve_vector(const Vector& b) const { return factor_->solve(b); }
Matrix PivotedQr::solve_matrix(const Matrix& B) const { return factor_->solve(B); }

// By rotations. BDCSVD, faster for many columns, does the same below 16, and the callers have six.
// It would cost the compiler three times as much.
RightSingular right_singular(const Matrix& A) {
  const Eigen::JacobiSVD<Matrix> svd(A, Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixV()};
}

namespace {

SymmetricEigen taken(const Eigen::SelfAdjointEigenSolver<Matrix>& solver) {
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

}  // namespace

SymmetricEigen symmetric_eigen(const Matrix& A) {
  if (A.size() == 0) return {Vector(0), Matrix(0, 0)};  // Eigen would read the first entry
  return taken(Eigen::SelfAdjointEigenSolver<Matrix>(A));
}

Vector symmetric_eigenvalues(const Matrix& A) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

SymmetricEigen tridiagonal_eigen(const Vector& diagonal, const Vector& beside) {
  Eigen::SelfAdjointEigenSolver<Matrix> solver;
  solver.computeFromTridiagonal(diagonal, beside, Eigen::ComputeEigenvectors);
  return taken(solver);
}

SymmetricEigen generalized_eigen(const Matrix& K, const Matrix& M) {
  if (K.size() == 0) return {Vector(0), Matrix(0, 0)};
  return taken(Eigen::GeneralizedSelfAdjointEigenSolver<Matrix>(K, M));
}

SymmetricEigen3 symmetric_eigen3(const Matrix3& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Vector3 symmetric_eigenvalues3(const Matrix3& A) {
  return Eigen::SelfAdjointEigenSolver<Matrix3>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

SymmetricEigen2 symmetric_eigen2(const Matrix2& A) {
  Eigen::SelfAdjointEigenSolver<Matrix2> solver;
  solver.computeDirect(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Vector random_signs(Index n) {
  Vector z(n);
  std::uint64_t state = 1;
  for (double& entry : z) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    entry = (state >> 63) != 0 ? 1.0 : -1.0;
  }
  return z;
}

}  // namespace cbr
