// SPDX-License-Identifier: GPL-3.0-or-later
// The interior of a component over all processes, and what a superelement takes from it.
#pragma once

#include <memory>

#include "common/app/report.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/distributed/interior_solver.hpp"
#include "reducer/judgement/condition_numbers.hpp"
#include "reducer/judgement/missing_modes.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"
#include "reducer/modes/interior_loads.hpp"

namespace cbr {

// As RigidMotions of one part: R_I, P_I of this process's rows (n_own x 6), R_C, P_C of the whole
// interface (c x 6).
struct RigidRows {
  Matrix R_I, R_C, P_I, P_C;

  RigidMotions on_interface() const;  // for follow_rigid_motions(), with R_C alone
};

struct DistributedInterior {
  InteriorRows rows;
  std::unique_ptr<InteriorSolver> solver;
  Points x_I, x_C;  // nodes of this process, of the interface
  RigidRows rigid;

  Index n_own() const { return rows.n_own; }
  Index c() const { return rows.K_CC.rows(); }
};

// Gathers the rows of all processes in the first one, in the interior's order (empty in the
// others). By columns, to store nothing else twice.
Matrix gather_rows(const InteriorRows& rows, const Matrix& own);

// A^T B over all rows   (columns of A x columns of B), to all processes.
Matrix inner(const Matrix& A, const Matrix& B);

// R^T M R of the six rigid motions about `center`, of the whole component   (6 x 6).
Matrix rigid_inertia(const DistributedInterior& interior, const Vector3& center);
RigidRows rigid_rows(const DistributedInterior& interior);

// As condition_numbers().
ConditionNumbers condition_numbers(const InteriorSolver& solver);
// As check_modes().
ModeCheck check_modes(const InteriorSolver& solver, const Vector& lambda, const Matrix& Phi);

// As condense(), by a second solve of each column, so that no process has more of Psi than its rows
// of one panel. The matrices are the first process's, and so is Psi, if it is to be kept. Phi:
// n_own x k.
Condensation condense(const DistributedInterior& interior, const Matrix& Phi, bool keep_Psi,
                      Report& report);

// Phi^T (M_IC + M_II Psi) of vectors that come later   (k x c, in the first process). M_cc:
// condense()'s, there.
Matrix mode_coupling(const DistributedInterior& interior, const Matrix& Phi, const Matrix& M_cc);

// As add_residual_vectors() and generalised_forces(), of forces on the own rows and, the same in
// all processes, on the interface.
Index add_residual_vectors(const InteriorSolver& solver, const Matrix& F_I,
                           FixedInterfaceModes& modes);
Matrix generalised_forces(const DistributedInterior& interior, const Matrix& F_I, const Matrix& F_C,
                          const Matrix& Phi, const Matrix& M_cc);

// As those of judgement/missing_modes.hpp, U (c x m) the same in all processes.
Matrix inertia_forces(const DistributedInterior& interior, const Matrix& M_cc, const Matrix& U);
LeftOfAnswer left_of_answer(const InteriorSolver& solver,
                            const std::vector<Eigen::Ref<const Matrix>>& modes,
                            const Vector& lambda, const Matrix& residual, Matrix Y);

}  // namespace cbr
