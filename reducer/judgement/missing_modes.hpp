// SPDX-License-Identifier: GPL-3.0-or-later
// The full model's lowest eigenvalues, from a reduced one's and the modes that it lacks
// (docs/theory.md, (12)).
#pragma once

#include <vector>

#include "reducer/partition/interior.hpp"

namespace cbr {

// Y = (M_IC + M_II Psi) U   (n_I x m): the interior's inertia forces under accelerations U (c x m)
// of the interface, negative. Psi follows rigid motions exactly, as in K_cc, M_cc and M_kc: Psi U =
// R_I G U - K_II^-1 K_IC (U - R_C G U).
Matrix inertia_forces(const Interior& interior, const Matrix& U);

// Residual of a response X = K_II^-1 Y, Y (n_I x m), outside the span of some vectors.
struct LeftOfAnswer {
  Matrix D, D_2;  // m x m: X^T K_II X and X^T M_II X of that residual X
};
// Modes: the columns of each of `modes` (n_I x any), M-orthonormal eigenvectors all of them
// together. `residual` vectors (lambda, n_I x r): no eigenvectors, but K- and M-orthogonal to the
// modes. Projects vectors instead of subtracting energies: the lowest modes have nearly all energy
// of a slender part, and the difference would be round-off. Y <- Y - M Phi Phi^T Y and X <- X - Phi
// Phi^T M X, X = K_II^-1 Y, each twice; then X <- X - Phi_r Lambda_r^-1 Phi_r^T Y. One solve a
// column.
LeftOfAnswer left_of_answer(const Interior& interior,
                            const std::vector<Eigen::Ref<const Matrix>>& modes,
                            const Vector& lambda, const Eigen::Ref<const Matrix>& residual,
                            Matrix Y);

// Modes that a basis lacks, as far as the motions U drive them: one by one, or those beyond some
// eigenvalue together.
struct MissingModes {
  Vector lambda;  // d, of those that are known, in any order
  Matrix A;       // d x m, alpha_j U
  // m x m, sum alpha_j^T alpha_j / lambda_j and / lambda_j^2 of the others, in U
  Matrix D, D_2;
  double beyond = 0;  // none of the others has a lower eigenvalue; 0: there are no others

  // S(sigma) = sigma^2 (sum A_j^T A_j / (lambda_j - sigma) + D + sigma D_2 / (1 - sigma / beyond))
  // of the leading m motions, sigma < lowest()   (m x m). Missing modes lower the dynamic stiffness
  // by S. The last term is an upper bound: D_2 assumes the lowest eigenvalue for all the others.
  // The rest is exact.
  Matrix taken(double sigma, Index m) const;
  double lowest() const;  // HUGE_VAL: nothing is missing
};

// Full model's eigenvalues number first .. first + count - 1, from below: sigma = eigenvalue of
// diag(lambda) - S(sigma), a Schur complement's, of the same number. lambda (ascending) and U,
// which `missing` is of: the reduced model's lowest modes, those beyond them being left out. Never
// above lowest(), as from there on the full model has modes that the reduced one has not. z (m x
// count, if given): the eigenvectors.
Vector full_eigenvalues(const Vector& lambda, const MissingModes& missing, Index first, Index count,
                        Matrix* z = nullptr);

}  // namespace cbr
