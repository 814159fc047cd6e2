// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/superelement/massless_modes.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/dense_factor.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/mesh/face_weights.hpp"

namespace cbr {
namespace {

constexpr Index most_ahead = 20;
// of the mean: docs/decisions/energy.md has the figures for others
constexpr double takes_part = 0.05;
constexpr double no_part = 1e-20;           // of |p|^2 |V_j|^2: round-off
constexpr double least_driven_mass = 1e-6;  // of a rigid motion's, in the modes

// Forces of a uniform pressure on each surface   (c x surfaces)
Matrix pressures(const Superelement& s) {
  Matrix P(s.c(), static_cast<Index>(s.surfaces.size()));
  for (Index q = 0; q < P.cols(); ++q) {
    const Points n = face_normals(s.surfaces[static_cast<std::size_t>(q)], s.coordinates);
    for (Index i = 0; i < s.c(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      P(i, q) = n(s.dof_node[at], s.dof_component[at]);
    }
  }
  return P;
}

}  // namespace

Index modes_ahead(Index elastic) { return std::clamp<Index>((elastic + 1) / 2, 1, most_ahead); }

double end_of_fall(const Superelement& s, const Matrix& V, const Vector& lambda, Index k,
                   Index n_rigid) {
  const Index e = k - n_rigid, last_looked_at = std::min(k + modes_ahead(e), lambda.size()) - 1;
  const Matrix P = pressures(s), answers = (P.transpose() * V).cwiseAbs2();  // surfaces x modes
  Vector enough = Vector::Constant(P.cols(), HUGE_VAL);
  bool any = false;
  for (Index q = 0; q < P.cols(); ++q) {
    const double rigid = answers.row(q).head(n_rigid).sum();
    const auto elastic = answers.row(q).segment(n_rigid, e);
    const double sum = rigid + elastic.sum(), mean = (rigid * rigid + elastic.squaredNorm()) / sum;
    if (!(sum > 0) || !(mean > no_part * P.col(q).squaredNorm() *
                                   V.leftCols(k).colwise().squaredNorm().maxCoeff()))
      continue;
    enough(q) = takes_part * mean;
    any = true;
  }
  const double last = k > 0 ? lambda(k - 1) : 0;
  Index j = k;
  const auto ends_here = [&] {
    return lambda(j) > last && (!any || (answers.col(j) - enough).maxCoeff() >= 0);
  };
  while (j < last_looked_at && !ends_here()) ++j;
  const double above = 1 + 1 / static_cast<double>(std::max<Index>(e, 1));
  return std::sqrt(j < lambda.size() && lambda(j) > last ? lambda(j) : above * above * last);
}

Vector falling_weights(const Vector& lambda, double end) {
  return (1 - (lambda.array().sqrt() / end).cube()).max(0.0).sqrt();
}

double take_fixed_modes(FixedModes modes, const Matrix& R, const Matrix& momentum,
                        Superelement& s) {
  const Index k = modes.lambda.size(), r = R.cols();
  if (k < r) {
    throw InputError("modes: " + std::to_string(k) + " fixed modes cannot carry the " +
                     std::to_string(r) +
                     " rigid motions: keep at least that many, preferably ten times as many");
  }
  // alpha <- alpha + alpha R (A^-1/2 - I) R^T M_cc, A = R^T alpha^T alpha R: the modes then have
  // all of the rigid mass, R^T alpha^T alpha R = I   (k x c). The symmetric root depends on no
  // choice of axes, as a Cholesky factor would.
  Matrix alpha = std::move(modes.alpha), alpha_R = alpha * R;
  const SymmetricEigen roots = symmetric_eigen(alpha_R.transpose() * alpha_R);
  const double least = r > 0 ? roots.values(0) : 1;
  if (!(least > least_driven_mass)) {
    throw InputError("modes: the " + std::to_string(k) +
                     " fixed modes do not take part in every rigid motion of the interface, so "
                     "that nothing would carry its mass: keep "
                     "more, or pick: participation");
  }
  const Matrix corrected = alpha_R * roots.inverse_root();
  alpha.noalias() += (corrected - alpha_R) * momentum.transpose();
  // F = (K_cc + alpha^T Lambda alpha)^-1   (c x c); U = F alpha^T Lambda   (c x k)
  Matrix F = std::move(modes.K_cc);
  const Matrix B = alpha.transpose() * modes.lambda.asDiagonal();
  F.noalias() += B * alpha;
  if (!dense_cholesky(F))
    throw InputError("modes: the fixed modes do not hold the interface: keep more");
  dense_inverse_of_cholesky(F);
  const Matrix U = F * B;
  // With the interface free of force: Lambda - Lambda alpha U, 0 for q = alpha R   (k x k)
  Matrix K = -B.transpose() * U;
  K.diagonal() += modes.lambda;
  K = 0.5 * (K + K.transpose()).eval();
  const Eigenpairs pairs = dense_eigenpairs_beside(std::move(K), corrected);
  if (!pairs.converged) throw RunError("the modes of the massless superelement could not be found");
  s.eigenvalues = pairs.lambda.cwiseMax(0);
  s.eigenvalues.head(r).setZero();
  s.massless.F = std::move(F);
  s.massless.V.noalias() = U * pairs.Phi;
  s.massless.V.leftCols(r) = R;
  s.massless.modes = "fixed";
  s.massless.rigid_momentum = momentum;
  s.massless.rigid_share = roots.root();
  s.massless.omega_closed = std::sqrt(modes.lambda.maxCoeff());
  return least;
}

FixedModes fixed_modes_of(const Superelement& s) {
  const auto& m = s.massless;
  Matrix K = m.F;
  if (!dense_cholesky(K))
    throw RunError("the compliance of a massless interface is not positive definite");
  dense_inverse_of_cholesky(K);
  // With the interface held, Phi^T Lambda Phi = diag(eigenvalues) + V^T F^-1 V, q = Phi p: its
  // modes are the rows of Phi.
  const Matrix K_V = K * m.V;
  Matrix held = m.V.transpose() * K_V;
  held.diagonal() += s.eigenvalues;
  const Eigenpairs pairs = dense_eigenpairs(0.5 * (held + held.transpose()).eval(), s.k());
  if (!pairs.converged)
    throw RunError("the fixed modes of a massless superelement could not be found");
  FixedModes modes;
  modes.lambda = pairs.lambda;
  // V = F alpha^T Lambda Phi
  const Matrix B = K_V * pairs.Phi;  // alpha^T Lambda   (c x k)
  modes.alpha = modes.lambda.cwiseInverse().asDiagonal() * B.transpose();
  K.noalias() -= B * modes.alpha;
  modes.K_cc = 0.5 * (K + K.transpose());
  const Matrix corrected = modes.alpha * m.V.leftCols(m.rigid_share.cols());
  modes.alpha.noalias() -= (corrected - corrected * m.rigid_share) * m.rigid_momentum.transpose();
  return modes;
}

}  // namespace cbr
