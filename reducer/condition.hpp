// SPDX-License-Identifier: GPL-3.0-or-later
// How far a reduction can be trusted: estimates that cost little beside it, from the factors that there are anyway.
#pragma once

#include <functional>
#include <limits>
#include <string>

#include "common/linalg/sparse_cholesky.hpp"
#include "common/report.hpp"
#include "common/superelement.hpp"
#include "reducer/partition.hpp"

namespace cbr {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

// Of a symmetric positive definite matrix, in the 1-norm. `scaled`: of D A D with D = diag(A)^-1/2, which does not depend on units
// and within a factor of the size is the least that a diagonal scaling can reach (van der Sluis 1969, doi 10.1007/BF02165096): its
// product with 1e-16 is what Cholesky's solutions lose.
struct ConditionNumbers {
  double plain = not_known, scaled = not_known;
};

// |A^-1|_1 from below, mostly within a factor of 2, by a handful of solves (Hager 1984, doi 10.1137/0905023; Higham 1988, doi
// 10.1145/50063.214386). solve: x <- A^-1 x (n).
double inverse_norm(Index n, const std::function<void(Vector&)>& solve);
ConditionNumbers condition_numbers(const SparseMatrix& A, const SparseCholesky& factor);

// Of the reduced mass M^ = [I M_kc; M_kc^T M_cc]; infinite when it is not positive definite. Takes c^3 / 3 flops.
ConditionNumbers reduced_mass_condition(const Superelement& superelement);

// Modes against Phi^T M_II Phi = I and K_II Phi = M_II Phi Lambda by one product with random signs z: what one mode has too much of
// another cannot hide but by chance.
struct ModeCheck {
  double orthogonality = 0;  // largest entry of Phi^T M_II Phi z - z
  Index worst = -1;          // its mode, from 0
  double residual = 0;       // |K_II w - M_II Phi z| / |M_II Phi z|, w = Phi Lambda^-1 z
};
ModeCheck check_modes(const Partition& partition, const Vector& lambda, const Matrix& Phi);

// Largest |sum_j K_ij r_j| of sum_j |K_ij| max |r| over the rows and the columns r of R (rigid motions), and its row. Of a dense,
// reduced K the largest sum of all rows counts.
struct RigidResidual {
  double value = 0;
  Index row = -1;
};
RigidResidual rigid_residual(const SparseMatrix& K, const Matrix& R);
RigidResidual rigid_residual(const Matrix& K, const Matrix& R);

// A motion that the reduced stiffness K_cc (c x c) hardly resists beside the rigid ones, the columns of R (c x r): the least
// x^T D K D x found by inverse iteration, |x| = 1, D = diag(K)^-1/2, x orthogonal to the rigid motions; and the dof that it moves
// most. What modes add is stiff. c^3 / 3 flops and a second c x c matrix.
struct SoftestMotion {
  double stiffness = not_known;
  Index dof = -1;
};
SoftestMotion softest_motion(Matrix K_cc, const Matrix& R);
bool is_without_stiffness(double softest);  // to round-off: a mechanism

// What one reduction, or what its domains make together, knows about itself. NaN, or 0 frequencies: not known.
struct ReductionCondition {
  ConditionNumbers K_II, mass;
  double smallest_pivot = not_known;  // SparseCholesky's
  ModeCheck modes;
  bool has_modes = false;  // `modes` is known
  std::string counts;      // of the inertia, "79 below 1.2e+06 Hz"; empty: none was made
  double rigid = not_known, reduced_rigid = not_known;
  double softest = not_known;                   // softest_motion(), where the frequencies are not known
  double largest_omega = 0, lowest_omega = 0;   // rad/s, of the reduced component: highest, and lowest that is not rigid
  Index n_zero = 0, n_rigid = 0;                // frequencies 0, and how many there have to be
  std::string weakest, rigid_node, loose_node;  // nodes, as messages name them
};

// Fills what a reduced component's matrices tell: the condition of its mass, and by its diagonal form, when there is one (n_rigid
// then has to be known), its frequencies, else the softest motion beside `rigid` (n x r, rows [k; c]). The interface dof that a
// motion without stiffness moves most; -1: there is none.
Index examine_reduced(const Superelement& superelement, const Matrix& rigid, ReductionCondition& condition);

// InputError when round-off has made the reduced stiffness resist rigid motions so much that no diagonal form can fit it.
void require_free(const ReductionCondition& condition);

// Figures for --verbose; `of_domain`: but those that only a whole component has. Warnings that say what to do.
void report_figures(const ReductionCondition& condition, Report& report, bool of_domain = false);
void warn_of_condition(const ReductionCondition& condition, Report& report);

// RunError naming both modes when one is there twice, or nearly so.
void require_independent(const Partition& partition, const Matrix& Phi, const ModeCheck& check);

}  // namespace cbr
