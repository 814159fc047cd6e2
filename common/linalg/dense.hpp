// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/linalg: dense algebra and its threads. With sparse and eigen below it, the
// only code that calls LAPACK, CHOLMOD and ARPACK.
//
// Factorisations and eigenpairs of dense matrices, compiled once. Eigen's decompositions stand
// behind this header and in no other: a file that instantiates one takes the compiler five to ten
// seconds (CONTRIBUTING.md, "Build time").
#pragma once

#include <memory>
#include <optional>
#include <type_traits>

#include "common/base/types.hpp"

namespace cbr {

using Matrix2 = Eigen::Matrix2d;

// Result of solve(b): a Vector for a vector, else a Matrix.
template <class Derived>
using DenseSolution = std::conditional_t<Derived::ColsAtCompileTime == 1, Vector, Matrix>;

// A = L L^T of a symmetric positive definite matrix (n x n); the lower triangle is read.
class Cholesky {
 public:
  explicit Cholesky(Matrix A);  // std::move(A) takes no copy

  bool ok() const { return ok_; }  // false: A is not positive definite
  // n x n: L in the lower triangle; the upper one is A's.
  const Matrix& factor() const { return L_; }
  Vector diagonal() const { return L_.diagonal(); }
  Matrix lower() const;  // n x n: L, zeros above
  Matrix upper() const;  // n x n: L^T, zeros below

  void solve_in_place(Vector& x) const;                   // x <- A^-1 x
  void solve_in_place(Eigen::Ref<Matrix> X) const;        // X <- A^-1 X
  void solve_lower_in_place(Eigen::Ref<Matrix> X) const;  // X <- L^-1 X
  void solve_upper_in_place(Eigen::Ref<Matrix> X) const;  // X <- L^-T X
  void divide_by_upper(Eigen::Ref<Matrix> X) const;       // X <- X L^-T   (m x n)
  Matrix times_upper(const Matrix& B) const;              // L^T B
  // A <- L^-1 A L^-T of a symmetric A, whose lower triangle alone is read and written
  void divide_both_sides(Matrix& A) const;

  template <class Derived>
  DenseSolution<Derived> solve(const Eigen::MatrixBase<Derived>& b) const {
    DenseSolution<Derived> x = b;
    solve_in_place(x);
    return x;
  }

 private:
  Matrix L_;
  bool ok_ = false;
};

// A = L L^T within a matrix: the lower triangle is read and becomes L. False when A is not positive
// definite.
bool cholesky_in_place(Eigen::Ref<Matrix> A);
// X <- X L^-T   (m x n); of L (n x n) the lower triangle is read.
void divide_by_upper(const Matrix& L, Eigen::Ref<Matrix> X);
// L of a 6 x 6 matrix, zeros above; nothing when it is not positive definite.
std::optional<Matrix6> small_cholesky(const Matrix6& A);

// solve() of a factorisation, by its solve_vector() and solve_matrix().
template <class Factor>
class Solves {
 public:
  template <class Derived>
  DenseSolution<Derived> solve(const Eigen::MatrixBase<Derived>& b) const {
    const auto& factor = static_cast<const Factor&>(*this);
    if constexpr (Derived::ColsAtCompileTime == 1)
      return factor.solve_vector(b);
    else
      return factor.solve_matrix(b);
  }
};

// A = P^T L D L^T P of a symmetric matrix (n x n) without pivots of both signs; the lower triangle
// is read.
class Ldlt : public Solves<Ldlt> {
 public:
  explicit Ldlt(const Matrix& A);

  Vector solve_vector(const Vector& b) const;  // A^-1 b
  Matrix solve_matrix(const Matrix& B) const;  // A^-1 B

 private:
  std::shared_ptr<const Eigen::LDLT<Matrix>> factor_;
};

// A^-1 b by L D L^T.
Vector3 solve_symmetric(const Matrix3& A, const Vector3& b);
// The same where A is positive semi-definite; else nothing.
std::optional<Vector3> solve_semidefinite(const Matrix3& A, const Vector3& b);

// P A = L U of a square matrix (n x n).
class Lu : public Solves<Lu> {
 public:
  explicit Lu(Matrix A);  // std::move(A) takes no copy

  double smallest_pivot() const;               // the least |U_ii|
  Matrix inverse() const;                      // A^-1
  Vector solve_vector(const Vector& b) const;  // A^-1 b
  Matrix solve_matrix(const Matrix& B) const;  // A^-1 B

 private:
  std::shared_ptr<const Eigen::PartialPivLU<Matrix>> factor_;
};

// A basis of the null space of A (m x n): n x dimension. Pivots up to `threshold` times the largest
// count as zero.
Matrix null_space(const Matrix& A, double threshold);

// A = Q R by Householder's reflections, without pivots.
struct Reflections {
  Matrix packed;  // m x n: R in the upper triangle, below it the reflections
  Vector tau;     // min(m, n)
};
Reflections householder_reflections(const Matrix& A);
// The first n columns of Q for A of m x n: an orthonormal basis of its columns when they are
// independent.
Matrix orthonormal_basis(const Matrix& A);
// All of Q for A of 3 x n: the first axis is that of the first column.
Matrix3 orthonormal_axes(const Matrix& A);

// A P = Q R of any matrix (m x n), the largest column first.
class PivotedQr : public Solves<PivotedQr> {
 public:
  explicit PivotedQr(const Matrix& A);  // threshold: round-off times min(m, n)
  PivotedQr(const Matrix& A, double threshold);

  Index rank() const;           // pivots up to the threshold times the largest count as zero
  Index column(Index j) const;  // which column of A has the j-th pivot
  Matrix Q() const;             // m x m
  Matrix3 axes() const;         // Q for m = 3
  // The x of least |A x - b|, n x (columns of b), with zeros for columns without a pivot. Every
  // pivot but 0 counts here.
  Vector solve_vector(const Vector& b) const;
  Matrix solve_matrix(const Matrix& B) const;

 private:
  std::shared_ptr<const Eigen::ColPivHouseholderQR<Matrix>> factor_;
};

// A = V diag(values) V^T of a symmetric matrix (n x n), ascending; the lower triangle is read.
struct SymmetricEigen {
  Vector values;
  Matrix vectors;
  bool converged = true;
};
SymmetricEigen symmetric_eigen(const Matrix& A);
Vector symmetric_eigenvalues(const Matrix& A);
// Of the tridiagonal matrix with this diagonal (n) and subdiagonal (n - 1).
SymmetricEigen tridiagonal_eigen(const Vector& diagonal, const Vector& beside);
// K v = lambda M v with V^T M V = I, M positive definite.
SymmetricEigen generalized_eigen(const Matrix& K, const Matrix& M);

// The same of 3 x 3 matrices, and of 2 x 2 ones in closed form.
struct SymmetricEigen3 {
  Vector3 values;
  Matrix3 vectors;
};
SymmetricEigen3 symmetric_eigen3(const Matrix3& A);
Vector3 symmetric_eigenvalues3(const Matrix3& A);
struct SymmetricEigen2 {
  Eigen::Vector2d values;
  Matrix2 vectors;
};
SymmetricEigen2 symmetric_eigen2(const Matrix2& A);

// A = U diag(values) V^T of any matrix (m x n), descending.
struct RightSingular {
  Vector values;  // min(m, n)
  Matrix V;       // n x min(m, n)
};
RightSingular right_singular(const Matrix& A);

// n entries, each 1 or -1, the same in every run.
Vector random_signs(Index n);

// A = L L^T in place (n x n, the lower triangle is read and overwritten, the rest left alone).
// False when A is not positive definite.
bool dense_cholesky(Matrix& A);

// From L in the lower triangle to (L L^T)^-1, both triangles, in place.
void dense_inverse_of_cholesky(Matrix& L);

// The upper triangle becomes that of a symmetric matrix whose lower triangle is given; by tiles, as
// columns alone thrash the cache.
void mirror_lower(Matrix& A);

}  // namespace cbr
