// SPDX-License-Identifier: GPL-3.0-or-later

#include <algorithm>
#include <cmath>
#include <random>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {
namespace {

// From p and q = M^-1 p: p_i ~ M_ii^1/2 as estimated by q, where masses differ widely. Else
// round-off of some coordinates (the rotations of a faint shell) exceeds the others.
void balance(const LinearMap& solve_M, Vector& p, Vector& q) {
  constexpr double alike = 1e10;
  double least = HUGE_VAL, most = 0;
  const auto flexibility = [&](Index i) {
    const double f = std::abs(q[i] / p[i]);
    return std::isfinite(f) ? f : 0.0;
  };
  for (Index i = 0; i < p.size(); ++i) {
    const double f = flexibility(i);
    if (f > 0) {
      least = std::min(least, f);
      most = std::max(most, f);
    }
  }
  if (!(most > alike * least)) return;
  for (Index i = 0; i < p.size(); ++i) {
    const double f = flexibility(i);
    if (f > 0) p[i] /= std::sqrt(f);
  }
  solve_M(p, q);
}

}  // namespace

RitzValue largest_ritz_value(const Vector& alpha, const Vector& beta, Index n) {
  // Eigen's QR of tridiagonal matrices compares squares of off-diagonal entries with the diagonal
  // (3.4). It judges only entries near 1 rightly. At 1e3 it may not converge, and then its values
  // are unsorted.
  double unit = alpha.head(n).cwiseAbs().maxCoeff();
  if (n > 1) unit = std::max(unit, beta.head(n - 1).cwiseAbs().maxCoeff());
  if (!alpha.head(n).allFinite() || !beta.head(n - 1).allFinite()) return {NAN, NAN};
  if (unit == 0) return {};
  const SymmetricEigen eigen = tridiagonal_eigen(alpha.head(n) / unit, beta.head(n - 1) / unit);
  if (!eigen.converged)
    throw RunError("the largest eigenvalue of a body or a contact was not found");
  return {unit * eigen.values[n - 1], std::abs(beta[n - 1] * eigen.vectors(n - 1, n - 1))};
}

double largest_eigenvalue(Index n, const LinearMap& multiply_K, const LinearMap& solve_M) {
  // To round-off's reach, so that neither the critical step nor a penalty depends on how nodes are
  // numbered
  const Index steps = std::min<Index>(500, std::max<Index>(n, 2));
  constexpr double enough = 1e-10;
  Index look = 10;
  std::mt19937_64 random(1);
  // q and p = M q, normalised by q . p: M itself is never asked for.
  Vector p =
      Vector::NullaryExpr(n, [&] { return static_cast<double>(random() >> 11) * 0x1p-53 - 0.5; });
  Vector q(n), Kq(n), w(n), p_before(n);
  solve_M(p, q);
  balance(solve_M, p, q);
  Vector alpha = Vector::Zero(steps), beta = Vector::Zero(steps);
  double norm = std::sqrt(std::max(q.dot(p), 0.0));
  if (!(norm > 0)) return 0;
  q /= norm;
  p /= norm;
  RitzValue bound;
  for (Index j = 0; j < steps; ++j) {
    // p_j+1 = K q_j - alpha_j p_j - beta_j-1 p_j-1, and q_j+1 solved from it. Separate recurrences
    // of both would drift apart and raise Ritz values above the spectrum.
    multiply_K(q, Kq);
    if (j > 0) Kq -= beta[j - 1] * p_before;
    alpha[j] = q.dot(Kq);
    Kq -= alpha[j] * p;
    solve_M(Kq, w);
    beta[j] = std::sqrt(std::max(w.dot(Kq), 0.0));
    const bool invariant = beta[j] <= 1e-13 * std::abs(alpha.head(j + 1).cwiseAbs().maxCoeff());
    if (invariant || j + 1 == look || j + 1 == steps) {
      look += std::max<Index>(10, look / 3);  // a look costs (j + 1)^3
      bound = largest_ritz_value(alpha, beta, j + 1);
      if (invariant || bound.residual <= enough * bound.value) break;
    }
    p_before.swap(p);
    q = w / beta[j];
    p = Kq / beta[j];
  }
  return bound.value + bound.residual;
}

}  // namespace cbr
