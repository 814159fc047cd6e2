// SPDX-License-Identifier: GPL-3.0-or-later
// How far a reduction can be trusted: estimates that cost little beside it, from the factors that
// there are anyway.
#pragma once

#include <functional>

#include "common/base/types.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "common/superelement/conditioning.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/partition/interior.hpp"

namespace cbr {

// |A^-1|_1 from below, mostly within a factor of 2, by a handful of solves (Hager 1984,
// doi 10.1137/0905023; Higham 1988, doi 10.1145/50063.214386). solve: x <- A^-1 x (n).
double inverse_norm(Index n, const std::function<void(Vector&)>& solve);

// The same search as questions and answers, for those who have several at a time.
class InverseNorm {
 public:
  explicit InverseNorm(Index n);

  bool is_done() const { return next_ == Next::nothing; }
  const Vector& asked() const { return asked_; }  // n
  void answer(const Vector& y);                   // A^-1 asked()
  double norm() const { return norm_; }

 private:
  enum class Next { length, slope, second_guess, nothing };

  void measure(const Vector& y);
  void climb(const Vector& z);
  void guess_again();

  Vector x_, asked_;
  double norm_ = 0;
  Index last_ = -1;
  int round_ = 0;
  Next next_ = Next::length;
};

ConditionNumbers condition_numbers(const SparseMatrix& A, const SparseCholesky& factor);

// Of the reduced mass M^ = [I M_kc; M_kc^T M_cc], by its residual_mass_factor(); infinite when it
// is not positive definite.
ConditionNumbers reduced_mass_condition(const Superelement& superelement, const Cholesky& M_res);
ConditionNumbers reduced_mass_condition(const Superelement& superelement);

// One product with random signs z: only chance can hide modes that are not orthonormal. Without
// modes the result is not known.
ModeCheck check_modes(const Interior& interior, const Vector& lambda, const Matrix& Phi);

// The softest motion of the reduced stiffness K_cc (c x c) beside rigid motions, the columns of R
// (c x r), and its largest dof. The least x^T D K D x, |x| = 1, D = diag(K)^-1/2, x orthogonal to
// the rigid motions, by inverse iteration. Motions that the modes add are stiff. c^3 / 3 flops and
// a second c x c matrix.
struct SoftestMotion {
  double stiffness = not_known;
  Index dof = -1;
};
SoftestMotion softest_motion(Matrix K_cc, const Matrix& R);

// rad/s, of K^ x = omega^2 M^ x, by Lanczos; NaN: M^ is not positive definite.
double largest_frequency(const Superelement& superelement, const Cholesky& M_res);

// Fills `condition` from a reduced component's matrices. Always the condition of the mass.
// Frequencies by the diagonal form or its lowest modes, if any (n_rigid must be set then), else the
// softest motion beside `rigid` (n x r, rows [k; c]). Returns the interface dof with the largest
// motion of a mechanism; -1: there is none. M_res: its residual_mass_factor().
Index examine_reduced(const Superelement& superelement, const Matrix& rigid, const Cholesky& M_res,
                      Conditioning& condition);

// RunError naming both modes when one is there twice, or nearly so.
void require_independent(const Interior& interior, const Matrix& Phi, const ModeCheck& check);

}  // namespace cbr
