// SPDX-License-Identifier: GPL-3.0-or-later
// How far a reduction can be trusted: estimates that cost little beside it, from the factors that
// there are anyway.
#pragma once

#include <functional>

#include "common/linalg/dense.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "common/superelement/conditioning.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/judgement/inverse_norm.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

ConditionNumbers condition_numbers(const SparseMatrix& A, const SparseCholesky& factor);

// Of the reduced mass M^ = [I M_kc; M_kc^T M_cc], by its residual_mass_factor(); infinite when it
// is not positive definite.
ConditionNumbers reduced_mass_condition(const Superelement& superelement, const Cholesky& M_res);
ConditionNumbers reduced_mass_condition(const Superelement& superelement);

// By one product with random signs z: what one mode has too much of another cannot hide but by
// chance. Without modes nothing is known.
ModeCheck check_modes(const Partition& partition, const Vector& lambda, const Matrix& Phi);

// A motion that the reduced stiffness K_cc (c x c) hardly resists beside the rigid ones, the
// columns of R (c x r): the least x^T D K D x found by inverse iteration, |x| = 1, D =
// diag(K)^-1/2, x orthogonal to the rigid motions; and the dof that it moves most. What modes add
// is stiff. c^3 / 3 flops and a second c x c matrix.
struct SoftestMotion {
  double stiffness = not_known;
  Index dof = -1;
};
SoftestMotion softest_motion(Matrix K_cc, const Matrix& R);

// rad/s, of K^ x = omega^2 M^ x, by Lanczos; NaN: M^ is not positive definite.
double largest_frequency(const Superelement& superelement, const Cholesky& M_res);

// Fills what a reduced component's matrices tell: the condition of its mass, and by its diagonal
// form or the lowest modes of it, when there is one (n_rigid then has to be known), its
// frequencies, else the softest motion beside `rigid` (n x r, rows [k; c]). The interface dof that
// a motion without stiffness moves most; -1: there is none. M_res: its residual_mass_factor().
Index examine_reduced(const Superelement& superelement, const Matrix& rigid, const Cholesky& M_res,
                      Conditioning& condition);

// RunError naming both modes when one is there twice, or nearly so.
void require_independent(const Partition& partition, const Matrix& Phi, const ModeCheck& check);

}  // namespace cbr
