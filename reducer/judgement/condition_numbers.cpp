// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/judgement/condition_numbers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/condensation/superelement_algebra.hpp"

namespace cbr {
namespace {

// Holds a motion without stiffness so far that a factor exists.
constexpr double no_singularity = 1e-14;

double column_norm(const SparseMatrix& A, const Vector& D) {
  double largest = 0;
  for (Index j = 0; j < A.cols(); ++j) {
    double sum = 0;
    for (SparseMatrix::InnerIterator it(A, j); it; ++it) sum += std::abs(it.value()) * D(it.row());
    largest = std::max(largest, sum * D(j));
  }
  return largest;
}

// Of M^ scaled by D on both sides.
double mass_norm(const Superelement& s, const Vector& D) {
  const auto D_k = D.head(s.k()), D_c = D.tail(s.c());
  double largest = 0;
  for (Index j = 0; j < s.c(); ++j) {
    double sum = s.M_cc.col(j).cwiseAbs().dot(D_c);
    if (s.k() > 0) sum += s.M_kc.col(j).cwiseAbs().dot(D_k);
    largest = std::max(largest, sum * D_c(j));
  }
  for (Index i = 0; i < s.k(); ++i)
    largest = std::max(largest, (D_k(i) + s.M_kc.row(i).transpose().cwiseAbs().dot(D_c)) * D_k(i));
  return largest;
}

// x = [a; b] <- M^-1 x: y_c = M_res^-1 (b - M_kc^T a), y_k = a - M_kc y_c
void solve_mass(const Superelement& s, const Cholesky& M_res, Vector& x) {
  const Index k = s.k(), c = s.c();
  if (c == 0) return;
  Vector y = x.tail(c);
  if (k > 0) y.noalias() -= s.M_kc.transpose() * x.head(k);
  M_res.solve_in_place(y);
  if (k > 0) x.head(k).noalias() -= s.M_kc * y;
  x.tail(c) = y;
}

}  // namespace

// Both numbers ask the factor at once, as it is read once for a few right-hand sides.
ConditionNumbers condition_numbers(const SparseMatrix& A, const SparseCholesky& factor) {
  const SingleThreadedBlas blas;  // solves of few vectors: memory is the limit
  const Index n = A.rows();
  if (n == 0) return {};
  const Vector diagonal = A.diagonal(), D = diagonal.cwiseSqrt().cwiseInverse(),
               one = Vector::Ones(n);
  // (D A D)^-1 = D^-1 A^-1 D^-1
  const std::array<const Vector*, 2> scale{&one, &D};
  std::array<InverseNorm, 2> search{InverseNorm(n), InverseNorm(n)};
  while (!search[0].is_done() || !search[1].is_done()) {
    std::vector<std::size_t> asks;
    for (std::size_t i = 0; i < search.size(); ++i)
      if (!search[i].is_done()) asks.push_back(i);
    Matrix X(n, static_cast<Index>(asks.size()));
    for (std::size_t j = 0; j < asks.size(); ++j)
      X.col(static_cast<Index>(j)) = search[asks[j]].asked().cwiseQuotient(*scale[asks[j]]);
    factor.solve_in_place(X);
    for (std::size_t j = 0; j < asks.size(); ++j)
      search[asks[j]].answer(X.col(static_cast<Index>(j)).cwiseQuotient(*scale[asks[j]]));
  }
  return {column_norm(A, one) * search[0].norm(), column_norm(A, D) * search[1].norm()};
}

ConditionNumbers reduced_mass_condition(const Superelement& s, const Cholesky& M_res) {
  const Index c = s.c(), n = s.n();
  if (n == 0) return {};
  const double infinite = std::numeric_limits<double>::infinity();
  if (!M_res.ok()) return {infinite, infinite};
  const auto solve = [&](Vector& x) { solve_mass(s, M_res, x); };
  Vector D = Vector::Ones(n);
  ConditionNumbers numbers;
  numbers.plain = mass_norm(s, D) * inverse_norm(n, solve);
  D.tail(c) = s.M_cc.diagonal().cwiseSqrt().cwiseInverse();
  numbers.scaled = mass_norm(s, D) * inverse_norm(n, [&](Vector& x) {
                     x = x.cwiseQuotient(D);
                     solve(x);
                     x = x.cwiseQuotient(D);
                   });
  return numbers;
}

ConditionNumbers reduced_mass_condition(const Superelement& s) {
  return reduced_mass_condition(s, residual_mass_factor(s));
}

ModeCheck check_modes(const Interior& interior, const Vector& lambda, const Matrix& Phi) {
  const Index k = lambda.size();
  if (k == 0) return {};
  ModeCheck check;
  const Vector z = random_signs(k);
  const Matrix M_Phi_z = interior.times_mass(Phi * z);
  const Vector along = interior.inner(Phi, M_Phi_z) - z;
  check.orthogonality = along.cwiseAbs().maxCoeff(&check.worst);
  const Matrix difference = interior.times_stiffness(Phi * z.cwiseQuotient(lambda)) - M_Phi_z;
  check.residual = interior.norm(difference) / interior.norm(M_Phi_z);
  return check;
}

void require_independent(const Interior& interior, const Matrix& Phi, const ModeCheck& check) {
  if (check.worst < 0 || !is_dependent(check.orthogonality)) return;
  Vector overlap = interior.inner(Phi, interior.times_mass(Phi.col(check.worst)));
  overlap(check.worst) = 0;
  Index other = 0;
  const double share = overlap.cwiseAbs().maxCoeff(&other);
  throw RunError(
      format_text("fixed-interface modes %lld and %lld are not independent of each other (Phi^T M "
                  "Phi is %.2g between them, not "
                  "0): the eigensolver has found one twice; ask for a few more or fewer modes",
                  static_cast<long long>(std::min(other, check.worst) + 1),
                  static_cast<long long>(std::max(other, check.worst) + 1), share));
}

SoftestMotion softest_motion(Matrix K, const Matrix& R) {
  const Index n = K.rows();
  if (n <= R.cols()) return {};
  // A row without any stiffness keeps its scale
  const double largest = K.diagonal().maxCoeff();
  if (!(largest > 0)) return {};
  const Vector D =
      K.diagonal().unaryExpr([&](double d) { return 1 / std::sqrt(d > 0 ? d : largest); });
  K = D.asDiagonal() * K * D.asDiagonal();
  // Springs of the size of its diagonal constrain the rigid motions; a soft motion then is another
  // one
  const Matrix Q = orthonormal_basis(D.cwiseInverse().asDiagonal() * R);
  const Matrix scaled = K;
  K.noalias() += Q * Q.transpose();
  K.diagonal().array() += no_singularity;
  const Cholesky cholesky(std::move(K));
  if (!cholesky.ok()) return {};
  Vector x = random_signs(n).normalized();
  for (int i = 0; i < 3; ++i) {
    x -= Q * (Q.transpose() * x);
    cholesky.solve_in_place(x);
    x.normalize();
  }
  x -= Q * (Q.transpose() * x);
  SoftestMotion softest;
  softest.stiffness = std::max(0.0, x.dot(scaled * x) / x.squaredNorm());
  x.cwiseProduct(D).cwiseAbs().maxCoeff(&softest.dof);
  return softest;
}

double largest_frequency(const Superelement& s, const Cholesky& M_res) {
  const Index k = s.k(), c = s.c();
  if (!M_res.ok()) return std::numeric_limits<double>::quiet_NaN();
  const SingleThreadedBlas blas;  // one vector after another: memory is the limit
  const auto times_stiffness = [&](const Vector& x, Vector& y) {
    y.resize(s.n());
    y.head(k) = s.eigenvalues.cwiseProduct(x.head(k));
    y.tail(c).noalias() = s.K_cc * x.tail(c);
  };
  const auto divided_by_mass = [&](const Vector& x, Vector& y) {
    y = x;
    solve_mass(s, M_res, y);
  };
  return std::sqrt(largest_eigenvalue(s.n(), times_stiffness, divided_by_mass));
}

Index examine_reduced(const Superelement& s, const Matrix& rigid, const Cholesky& M_res,
                      Conditioning& c) {
  Index dof = -1;
  c.mass = reduced_mass_condition(s, M_res);
  if (!s.has_diagonal_form()) {
    if (s.c() == rigid.cols()) return dof;  // one point, which nothing resists
    const SoftestMotion softest = softest_motion(s.K_cc, rigid.bottomRows(s.c()));
    c.softest = softest.stiffness;
    return is_without_stiffness(c.softest) ? softest.dof : -1;
  }
  const Index known = s.omega.size();  // all, or the lowest
  c.n_zero = (s.omega.array() == 0).count();
  c.largest_omega = known == s.n() ? s.omega(known - 1) : largest_frequency(s, M_res);
  if (c.n_zero < known) c.lowest_omega = s.omega(c.n_zero);
  if (c.n_zero > c.n_rigid) s.V.col(c.n_rigid).tail(s.c()).cwiseAbs().maxCoeff(&dof);
  return dof;
}

namespace {

constexpr int most_rounds = 5;

}  // namespace

double inverse_norm(Index n, const std::function<void(Vector&)>& solve) {
  InverseNorm search(n);
  while (!search.is_done()) {
    Vector x = search.asked();
    solve(x);
    search.answer(x);
  }
  return search.norm();
}

InverseNorm::InverseNorm(Index n)
    : x_(Vector::Constant(n, n > 0 ? 1.0 / static_cast<double>(n) : 0)), asked_(x_) {
  if (n == 0) next_ = Next::nothing;
}

void InverseNorm::answer(const Vector& y) {
  switch (next_) {
    case Next::length:
      return measure(y);
    case Next::slope:
      return climb(y);
    case Next::second_guess:
      norm_ = std::max(norm_, 2 * y.lpNorm<1>() / (3 * static_cast<double>(y.size())));
      next_ = Next::nothing;
      return;
    case Next::nothing:
      return;
  }
}

void InverseNorm::measure(const Vector& y) {
  const double found = y.lpNorm<1>();
  if (round_ > 0 && !(found > norm_)) return guess_again();
  norm_ = found;
  asked_ = y.unaryExpr([](double v) { return v >= 0 ? 1.0 : -1.0; });
  next_ = Next::slope;
}

void InverseNorm::climb(const Vector& z) {
  Index j = 0;
  const double steepest = z.cwiseAbs().maxCoeff(&j);
  if (!(steepest > z.dot(x_)) || j == last_ || ++round_ == most_rounds) return guess_again();
  x_.setZero();
  x_(j) = 1;
  last_ = j;
  asked_ = x_;
  next_ = Next::length;
}

// Higham's second guess, for matrices that are made to mislead the first.
void InverseNorm::guess_again() {
  const Index n = x_.size();
  for (Index i = 0; i < n; ++i)
    asked_(i) = (i % 2 == 0 ? 1 : -1) *
                (1 + static_cast<double>(i) / static_cast<double>(std::max<Index>(n - 1, 1)));
  next_ = Next::second_guess;
}

}  // namespace cbr
