// SPDX-License-Identifier: GPL-3.0-or-later
// How far a reduction can be trusted: estimates that cost little beside it, from the factors that there are anyway.
#pragma once

#include <functional>
#include <string>

#include "common/linalg/sparse_cholesky.hpp"
#include "common/report.hpp"
#include "common/superelement.hpp"
#include "reducer/partition.hpp"

namespace cbr {

// Of a symmetric positive definite matrix, in the 1-norm. `scaled`: of D A D with D = diag(A)^-1/2, which does not depend on units
// and within a factor of the size is the least that a diagonal scaling can reach (van der Sluis 1969, doi 10.1007/BF02165096): its
// product with 1e-16 is what Cholesky's solutions lose.
struct ConditionNumbers {
  double plain = 1, scaled = 1;
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

// What one reduction knows about itself. 0 or negative: not known.
struct ReductionCondition {
  ConditionNumbers K_II, mass;
  double smallest_pivot = 1;  // SparseCholesky's
  ModeCheck modes;
  std::string counts;  // of the inertia, "79 below 1.2e+06 Hz"; empty: none was made
  double rigid = 0, reduced_rigid = 0;
  double largest_omega = 0, lowest_omega = 0;   // rad/s, of the reduced component: highest, and lowest that is not rigid
  Index n_zero = 0, n_rigid = 0;                // frequencies 0, and how many there have to be
  std::string weakest, rigid_node, loose_node;  // nodes, as messages name them
};

// InputError when round-off has made the reduced stiffness resist rigid motions so much that no diagonal form can fit it.
void require_free(const ReductionCondition& condition);

// Figures for --verbose, and warnings that say what to do.
void report_condition(const ReductionCondition& condition, Report& report);

// RunError naming both modes when one is there twice, or nearly so.
void require_independent(const Partition& partition, const Matrix& Phi, const ModeCheck& check);

}  // namespace cbr
