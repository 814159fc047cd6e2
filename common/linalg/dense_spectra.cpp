// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>

#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

SymmetricEigen taken(const Eigen::SelfAdjointEigenSolver<Matrix>& solver) {
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

}  // namespace

Matrix SymmetricEigen::root() const {
  return vectors * values.cwiseSqrt().asDiagonal() * vectors.adjoint();
}
Matrix SymmetricEigen::inverse_root() const {
  return vectors * values.cwiseInverse().cwiseSqrt().asDiagonal() * vectors.adjoint();
}

SymmetricEigen symmetric_eigen(const Matrix& A) {
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

}  // namespace cbr
