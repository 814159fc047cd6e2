// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/modes: modes with the interface held, residual vectors of loads, the
// diagonal form.
//
// K_II Phi = M_II Phi Lambda, Phi^T M_II Phi = I: modes of the component with its interface held.
#pragma once

#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/base/types.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "common/scene/scene.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

struct FixedInterfaceModes {
  Vector lambda;       // k, (rad/s)^2, ascending
  Matrix Phi;          // n_I x k
  std::string method;  // none, arpack, block lanczos, lapack
  // by an inertia count that no mode below the last one is missing; dense ones miss none
  bool proven = false;
  // lambda of the next mode, which is not kept; 0: there is none, or none was computed
  double next = 0;
  std::string counts = {};  // of the inertia: "79 below 1.2e+06 Hz, 79 found"; empty: none was made
};

// True if the dense solver is the faster one for k of n_I modes. Measured:
// docs/decisions/eigen-crossover.md.
bool dense_is_faster(Index n, Index k, double factor_nonzeros);

// InputError: fewer than k of n_I dofs.
void require_dofs_for_modes(Index k, Index n_interior);

// Relative residual of modes that a basis alone uses (docs/decisions/reduction.md). Eigenvalues are
// right to its square, and M_kc comes from solves.
constexpr double basis_residual = 1e-4;
constexpr double basis_precision = 1e-7;  // of eigenvalues: ten times the square

// The k lowest. InputError when there are fewer than k; RunError when the eigensolver does not
// converge. residual: relative, enough for the vectors; Phi^T K Phi is diagonal whatever it is.
FixedInterfaceModes fixed_interface_modes(const Partition& partition, const SparseCholesky& factor,
                                          Index k, Report& report, double residual = 1e-13);

// The k lowest (all, where there are fewer) when some lowest ones are known already: these are not
// solved for again. Where the dense solver is the faster one, all n_I come.
FixedInterfaceModes more_modes(const Partition& partition, const SparseCholesky& factor,
                               FixedInterfaceModes known, Index k, Report& report);

// How many there are below a frequency (Hz), by the inertia of K_II - (2 pi f)^2 M_II.
Index count_modes_below(const Partition& partition, const SparseCholesky& factor,
                        double frequency_hz, Report& report);

// Modes that are computed so that `wanted` can be kept; more than wanted with pick: participation.
Index n_mode_candidates(Pick pick, Index wanted, Index n_interior);

// Indices (ascending) of the `count` rows of M_kc with the largest |alpha_j|^2: the modes that an
// interface motion drives most.
std::vector<Index> modes_by_participation(const Matrix& M_kc, Index count);

// InputError unless exactly one of modes, cutoff_hz and tolerance is given, in range.
void check_modes_wanted(const ReductionOptions& options);

// Where the last mode that is kept and the next (0: not known) have one frequency, which of their
// shapes is kept is arbitrary.
void warn_of_cut_pair(const Vector& lambda, double next, Report& report);

}  // namespace cbr
