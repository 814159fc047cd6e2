// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/diagonal_form.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/error.hpp"
#include "common/linalg/eigenpairs.hpp"

namespace cbr {
namespace {

// M^ X without forming M^ = [I M_kc; M_kc^T M_cc]   (n x m)
Matrix times_mass(const Superelement& s, const Matrix& X) {
  const auto X_k = X.topRows(s.k()), X_c = X.bottomRows(s.c());
  Matrix Y(s.n(), X.cols());
  Y.topRows(s.k()) = X_k + s.M_kc * X_c;
  Y.bottomRows(s.c()) = s.M_kc.transpose() * X_k + s.M_cc * X_c;
  return Y;
}

// K^ V = M^ V diag(lambda), V^T M^ V = I. With L L^T = M_cc - M_kc^T M_kc and B = M_kc L^-T, q = T z,
//   T = [I  -B  ]    T^T M^ T = I    A = T^T K^ T = [ Lambda      -Lambda B                   ]
//       [0  L^-T],                                  [ -B^T Lambda  B^T Lambda B + L^-1 K_cc L^-T ],
// so nothing of the size n^3 is spent on making the problem a standard one, and neither K^ nor M^ is formed. R (n x r): the rigid
// motions, R^T M^ R = I, no part along modes, which get lambda = 0.
Eigenpairs reduced_eigenpairs(const Superelement& s, const Matrix& R) {
  const Index k = s.k(), c = s.c(), n = s.n();
  Matrix L = s.M_cc;
  if (k > 0) L.noalias() -= s.M_kc.transpose() * s.M_kc;
  const Eigen::LLT<Eigen::Ref<Matrix>> cholesky(L);  // in place
  if (cholesky.info() != Eigen::Success) return {};
  // B = M_kc L^-T   (k x c)
  Matrix B = s.M_kc;
  if (k > 0 && c > 0) cholesky.matrixU().solveInPlace<Eigen::OnTheRight>(B);
  Matrix A(n, n);  // lower triangle
  A.topLeftCorner(k, k).setZero();
  A.diagonal().head(k) = s.eigenvalues;
  if (c > 0) {
    // L^-1 K_cc L^-T + B^T Lambda B   (c x c)
    Matrix D = s.K_cc;
    cholesky.matrixL().solveInPlace(D);
    cholesky.matrixU().solveInPlace<Eigen::OnTheRight>(D);
    A.bottomLeftCorner(c, k).noalias() = -(B.transpose() * s.eigenvalues.asDiagonal());
    if (k > 0) D.noalias() -= A.bottomLeftCorner(c, k) * B;
    A.bottomRightCorner(c, c) = D;
  }
  // T^-1 R = [M_kc R_c; L^T R_c]   (n x r)
  Matrix Q(n, R.cols());
  if (k > 0 && Q.cols() > 0) Q.topRows(k) = s.M_kc * R.bottomRows(c);
  if (Q.cols() > 0) Q.bottomRows(c) = cholesky.matrixU() * R.bottomRows(c);
  Eigenpairs pairs = dense_eigenpairs_beside(std::move(A), Q);
  if (!pairs.converged || c == 0) return pairs;
  // V = T Z: V_c = L^-T Z_c, V_k = Z_k - M_kc V_c   (n x n)
  auto V_c = pairs.Phi.bottomRows(c);
  cholesky.matrixU().solveInPlace(V_c);
  if (k > 0) pairs.Phi.topRows(k).noalias() -= s.M_kc * V_c;
  fix_signs(pairs.Phi);
  return pairs;
}

// R <- R L^-T with R^T M^ R = L L^T; twice, as the first pass leaves cond(R) times round-off.
void orthonormalise(const Superelement& s, Matrix& R) {
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::LLT<Matrix> llt(R.transpose() * times_mass(s, R));
    if (llt.info() != Eigen::Success) throw RunError("the reduced mass of the rigid motions is not positive definite");
    llt.matrixU().solveInPlace<Eigen::OnTheRight>(R);
  }
}

}  // namespace

Matrix rigid_motions_of_parts(const Superelement& s, const std::vector<Index>& part) {
  const Index n_parts = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
  std::vector<Vector> columns;
  for (Index number = 0; number < n_parts; ++number) {
    Vector3 center = Vector3::Zero();
    double count = 0, size = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (part[i] == number) center += Vector3(s.coordinates.row(static_cast<Index>(i))), count += 1;
    }
    if (count == 0) continue;
    center /= count;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (part[i] == number) size = std::max(size, (Vector3(s.coordinates.row(static_cast<Index>(i))) - center).norm());
    }
    // Rotations about the part's centre, scaled by its size, so that all six are of the same magnitude.
    const Points x = (s.coordinates.rowwise() - center.transpose()) / (size > 0 ? size : 1.0);
    const Matrix all = rigid_modes(x, Vector3::Zero());
    Matrix R = Matrix::Zero(s.n(), 6);
    for (Index i = 0; i < s.c(); ++i) {
      const auto node = static_cast<std::size_t>(s.dof_node[static_cast<std::size_t>(i)]);
      if (part[node] == number)
        R.row(s.k() + i) = all.row(3 * s.dof_node[static_cast<std::size_t>(i)] + s.dof_component[static_cast<std::size_t>(i)]);
    }
    // A part that is all interface may be as small as one node of a mechanism: only independent motions count.
    Eigen::ColPivHouseholderQR<Matrix> qr(R);
    qr.setThreshold(1e-10);
    for (Index j = 0; j < qr.rank(); ++j) columns.emplace_back(R.col(qr.colsPermutation().indices()(j)));
  }
  Matrix R(s.n(), static_cast<Index>(columns.size()));
  for (Index j = 0; j < R.cols(); ++j) R.col(j) = columns[static_cast<std::size_t>(j)];
  return R;
}

Index add_diagonal_form(Superelement& s, const std::vector<Index>& part) {
  Matrix R = rigid_motions_of_parts(s, part);
  const Index n_rigid = R.cols();
  add_diagonal_form(s, std::move(R));
  return n_rigid;
}

void add_diagonal_form(Superelement& s, Matrix R) {
  const Index n = s.n(), n_rigid = R.cols();
  if (n_rigid > 0) orthonormalise(s, R);
  Eigenpairs pairs = reduced_eigenpairs(s, R);
  if (!pairs.converged) {
    throw RunError(
        "the reduced mass matrix is not positive definite, so there is no diagonal form: keep fewer modes, or "
        "widen the interface (no integrator can do without a positive definite mass)");
  }
  fix_signs(R);
  auto elastic = pairs.Phi.rightCols(n - n_rigid);
  // V_e <- V_e - R (R^T M^ V_e)   (n x n_e)
  const Matrix overlap = times_mass(s, R).transpose() * elastic;
  elastic.noalias() -= R * overlap;
  pairs.Phi.leftCols(n_rigid) = R;
  // Below this the eigensolver cannot tell an eigenvalue from 0: a mechanism inside the interface.
  const double noise = n > 0 ? 10 * std::numeric_limits<double>::epsilon() * std::abs(pairs.lambda(n - 1)) : 0.0;
  s.omega = Vector::Zero(n);
  for (Index j = n_rigid; j < n; ++j) s.omega(j) = pairs.lambda(j) > noise ? std::sqrt(pairs.lambda(j)) : 0.0;
  s.V = std::move(pairs.Phi);
}

}  // namespace cbr
