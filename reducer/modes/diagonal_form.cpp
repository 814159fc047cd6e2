// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/modes/diagonal_form.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/block_lanczos.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/condensation/superelement_algebra.hpp"

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

// K^ V = M^ V diag(lambda), V^T M^ V = I. With L L^T = M_cc - M_kc^T M_kc and B = M_kc L^-T, q = T
// z,
//   T = [I  -B  ]    T^T M^ T = I    A = T^T K^ T = [ Lambda      -Lambda B                   ]
//       [0  L^-T],                                  [ -B^T Lambda  B^T Lambda B + L^-1 K_cc L^-T ],
// so nothing of the size n^3 is spent on making the problem a standard one, and neither K^ nor M^
// is formed. R (n x r): the rigid motions, R^T M^ R = I, no part along modes, which get lambda = 0.
Eigenpairs reduced_eigenpairs(const Superelement& s, const Matrix& R, const Cholesky* M_res) {
  const Index k = s.k(), c = s.c(), n = s.n();
  std::optional<Cholesky> own;
  const Cholesky& cholesky = M_res != nullptr ? *M_res : own.emplace(residual_mass_factor(s));
  if (!cholesky.ok()) return {};
  // B = M_kc L^-T   (k x c)
  Matrix B = s.M_kc;
  if (k > 0 && c > 0) cholesky.divide_by_upper(B);
  Matrix A(n, n);  // lower triangle
  A.topLeftCorner(k, k).setZero();
  A.diagonal().head(k) = s.eigenvalues;
  if (c > 0) {
    // L^-1 K_cc L^-T + B^T Lambda B   (c x c)
    Matrix D = s.K_cc;  // lower triangle
    cholesky.divide_both_sides(D);
    A.bottomLeftCorner(c, k).noalias() = -(B.transpose() * s.eigenvalues.asDiagonal());
    if (k > 0) D.noalias() -= A.bottomLeftCorner(c, k) * B;
    A.bottomRightCorner(c, c) = D;
  }
  // T^-1 R = [M_kc R_c; L^T R_c]   (n x r)
  Matrix Q(n, R.cols());
  if (k > 0 && Q.cols() > 0) Q.topRows(k) = s.M_kc * R.bottomRows(c);
  if (Q.cols() > 0) Q.bottomRows(c) = cholesky.times_upper(R.bottomRows(c));
  Eigenpairs pairs = dense_eigenpairs_beside(std::move(A), Q);
  if (!pairs.converged || c == 0) return pairs;
  // V = T Z: V_c = L^-T Z_c, V_k = Z_k - M_kc V_c   (n x n)
  auto V_c = pairs.Phi.bottomRows(c);
  cholesky.solve_upper_in_place(V_c);
  if (k > 0) pairs.Phi.topRows(k).noalias() -= s.M_kc * V_c;
  fix_signs(pairs.Phi);
  return pairs;
}

// Sets omega and V of the rigid motions R, M^-orthonormal, and of elastic pairs, whose rigid
// motions are taken out once more.
void take_modes(Superelement& s, Matrix R, const Eigenpairs& elastic) {
  const Index r = R.cols(), e = elastic.lambda.size();
  s.omega = Vector::Zero(r + e);
  s.omega.tail(e) = elastic.lambda.cwiseMax(0.0).cwiseSqrt();
  fix_signs(R);
  // V_e <- V_e - R (R^T M^ V_e)   (n x e)
  const Matrix overlap = times_mass(s, R).transpose() * elastic.Phi;
  s.V.resize(s.n(), r + e);
  s.V.leftCols(r) = R;
  s.V.rightCols(e) = elastic.Phi - R * overlap;
}

// True if X (n x m, X^T M^ X = 1) has all eigenvectors of eigenvalues below the shift: K^ - shift
// M^ is positive definite once X is lifted above it.
bool has_all_below(const Superelement& s, const Matrix& X, double shift) {
  const Index k = s.k(), c = s.c();
  const Matrix MX = std::sqrt(2 * shift) * times_mass(s, X);
  // K^ - shift M^ + 2 shift (M^ X) (M^ X)^T, lower triangle   (n x n)
  Matrix D = Matrix::Zero(s.n(), s.n());
  D.topLeftCorner(k, k).diagonal() = s.eigenvalues.array() - shift;
  D.bottomLeftCorner(c, k) = -shift * s.M_kc.transpose();
  D.bottomRightCorner(c, c) = s.K_cc - shift * s.M_cc;
  D.selfadjointView<Eigen::Lower>().rankUpdate(MX);
  return dense_cholesky(D);
}

// Between two of the last eigenvalues, where the gap is widest: number of those below it.
Index last_wide_gap(const Vector& lambda) {
  constexpr Index looked_at = 6;
  Index best = lambda.size() - 1;
  for (Index j = std::max<Index>(1, lambda.size() - looked_at); j < lambda.size(); ++j)
    if ((lambda(j) - lambda(j - 1)) * lambda(best) > (lambda(best) - lambda(best - 1)) * lambda(j))
      best = j;
  return best;
}

// Smaller problems are solved densely in no time; larger shares of all modes cost as much by
// Lanczos.
constexpr Index worth_lanczos = 500, least_ratio = 6;
// Of residuals: of eigenvalues its square.
constexpr double lanczos_tolerance = 1e-11;
constexpr Index least_basis = 500;
// A mechanism's eigenvalue is 0 relative to the others: then all eigenvalues are computed.
constexpr double no_strain = 1e-10;

// The lowest `count` elastic modes by block Lanczos with the flexibility (1 - R R^T M^) K~^-1 (1 -
// M^ R R^T). K~ is K^ with its rigid motions constrained. Factoring K~_c costs c^3 / 3 flops, the
// dense way 4/3 n^3 at the memory's rate. R (n x r, R^T M^ R = 1) has no part along modes. Not
// converged where K~ is not positive definite, or a mode is missing by the count of modes below the
// last.
Eigenpairs lowest_by_lanczos(const Superelement& s, const Matrix& R, Index count) {
  const Index k = s.k(), c = s.c(), n = s.n();
  Eigenpairs none;
  if (n < worth_lanczos || n < least_ratio * (count + R.cols()) || c == 0) return none;
  if (k > 0 && !(s.eigenvalues.minCoeff() > 0)) return none;
  const Cholesky held(hold_rigid_motions(s.K_cc, R.bottomRows(c)).K);
  if (!held.ok()) return none;
  const Matrix MR = times_mass(s, R);
  const auto solve = [&](Eigen::Ref<Matrix> B) {
    B -= MR * Matrix(R.transpose() * B);
    if (k > 0) B.topRows(k).array().colwise() /= s.eigenvalues.array();
    auto B_c = B.bottomRows(c);
    held.solve_in_place(B_c);
    B -= R * Matrix(MR.transpose() * B);
  };
  BlockLanczosOptions options;
  options.tolerance = lanczos_tolerance;
  options.basis = std::max(n / 4, least_basis);
  options.max_restarts = 0;
  // One more than is wanted, above the gap that they are counted at
  Eigenpairs pairs = block_lanczos(
      n, [&](const Eigen::Ref<const Matrix>& U, Matrix& P) { P = times_mass(s, U); }, solve, 0,
      count + 1, options);
  if (!pairs.converged || pairs.lambda(0) < no_strain * pairs.lambda(count)) return none;
  const Index below = last_wide_gap(pairs.lambda);
  Matrix X(n, R.cols() + below);
  X << R, pairs.Phi.leftCols(below);
  if (!has_all_below(s, X, 0.5 * (pairs.lambda(below - 1) + pairs.lambda(below)))) return none;
  pairs.lambda.conservativeResize(count);
  pairs.Phi.conservativeResize(Eigen::NoChange, count);
  fix_signs(pairs.Phi);
  return pairs;
}

// All modes, or rigid motions and elastic ones up to `count` in all. By Lanczos, or of all, as only
// the largest eigenvalue shows which others are 0.
void add_modes(Superelement& s, Matrix R, std::optional<Index> count,
               const Cholesky* M_res = nullptr) {
  const Index n = s.n(), n_rigid = R.cols();
  if (n_rigid > 0)
    orthonormalise([&](const Matrix& X) { return times_mass(s, X); }, R, "the rigid motions");
  if (count) {
    const Eigenpairs lowest = lowest_by_lanczos(s, R, *count - n_rigid);
    if (lowest.converged) return take_modes(s, std::move(R), lowest);
  }
  Eigenpairs pairs = reduced_eigenpairs(s, R, M_res);
  if (!pairs.converged) {
    throw InputError(
        "the reduced mass matrix is not positive definite, so there is no diagonal form (no "
        "integrator can do without), as round-off makes that of very thin parts: use larger or "
        "less flat elements, keep fewer modes, or widen the interface");
  }
  fix_signs(R);
  auto elastic = pairs.Phi.rightCols(n - n_rigid);
  // V_e <- V_e - R (R^T M^ V_e)   (n x n_e)
  const Matrix overlap = times_mass(s, R).transpose() * elastic;
  elastic.noalias() -= R * overlap;
  pairs.Phi.leftCols(n_rigid) = R;
  // Eigenvalues below this are 0 to the eigensolver's round-off: a mechanism of the interface.
  const double noise =
      n > 0 ? 10 * std::numeric_limits<double>::epsilon() * std::abs(pairs.lambda(n - 1)) : 0.0;
  const Index kept = count.value_or(n);
  s.omega = Vector::Zero(kept);
  for (Index j = n_rigid; j < kept; ++j)
    s.omega(j) = pairs.lambda(j) > noise ? std::sqrt(pairs.lambda(j)) : 0.0;
  s.V = std::move(pairs.Phi);
  if (kept < n) s.V = RowMatrix(s.V.leftCols(kept));
}

}  // namespace

Index add_diagonal_form(Superelement& s, const std::vector<Index>& part, const Cholesky* M_res) {
  Matrix R = rigid_motions_of_parts(s, part);
  const Index n_rigid = R.cols();
  add_modes(s, std::move(R), {}, M_res);
  return n_rigid;
}

void add_diagonal_form(Superelement& s, Matrix R) { add_modes(s, std::move(R), {}); }

Index add_lowest_modes(Superelement& s, const std::vector<Index>& part, Index count) {
  Matrix R = rigid_motions_of_parts(s, part);
  const Index n_rigid = R.cols();
  if (n_rigid + count < s.n()) {
    add_modes(s, std::move(R), n_rigid + count);
  } else {
    add_modes(s, std::move(R), {});
  }
  return n_rigid;
}

}  // namespace cbr
