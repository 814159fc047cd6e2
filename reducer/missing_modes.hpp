// SPDX-License-Identifier: GPL-3.0-or-later
// What the full model's lowest eigenvalues are, from a reduced one's and what its modes lack (docs/theory.md, 5i).
#pragma once

#include "common/linalg/sparse_cholesky.hpp"
#include "reducer/partition.hpp"

namespace cbr {

// Y = (M_IC + M_II Psi) U   (n_I x m), Psi U = -K_II^-1 K_IC U: the interior's inertia forces under accelerations U (c x m),
// negative.
Matrix inertia_forces(const Partition& p, const SparseCholesky& factor, const Matrix& U);

// All that the interior answers to interface motions U.
struct InteriorAnswer {
  Matrix Y;       // n_I x m, inertia_forces()
  Matrix E, E_2;  // m x m, Y^T K_II^-1 Y and Y^T K_II^-1 M_II K_II^-1 Y
};
InteriorAnswer interior_answer(const Partition& p, const SparseCholesky& factor, const Matrix& U);

// Modes that a basis lacks, as far as the motions U drive them: one by one, or those beyond some eigenvalue together.
struct MissingModes {
  Vector lambda;      // d, of those that are known, in any order
  Matrix A;           // d x m, alpha_j U
  Matrix D, D_2;      // m x m, sum alpha_j^T alpha_j / lambda_j and / lambda_j^2 of the others, in U
  double beyond = 0;  // none of the others has a lower eigenvalue; 0: there are no others

  // S(sigma) = sigma^2 (sum A_j^T A_j / (lambda_j - sigma) + D + sigma D_2 / (1 - sigma / beyond)) of the leading m motions, for
  // sigma < lowest(): what missing modes take from the reduced stiffness in motion. Exact but for the last term, which is an upper
  // bound, D_2 taking all the others to be as low as the lowest of them.   (m x m)
  Matrix taken(double sigma, Index m) const;
  double lowest() const;  // HUGE_VAL: nothing is missing
};

// D <- D - A^T diag(1 / lambda) A, D_2 <- D_2 - A^T diag(1 / lambda^2) A
void take_out(const Vector& lambda, const Matrix& A, Matrix& D, Matrix& D_2);

// Full model's eigenvalues number first .. first + count - 1, from below: sigma = eigenvalue of diag(lambda) - S(sigma), a Schur
// complement's, of the same number. lambda (ascending) and U, which `missing` is of: the reduced model's lowest modes, those beyond
// them being left out. Never above lowest(), as from there on the full model has modes that the reduced one has not.
// z (m x count, if given): the eigenvectors.
Vector full_eigenvalues(const Vector& lambda, const MissingModes& missing, Index first, Index count, Matrix* z = nullptr);

}  // namespace cbr
