// SPDX-License-Identifier: GPL-3.0-or-later
// What one reduction tells of its errors, for each basis.
#pragma once

#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/bases/reduction_steps.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"

namespace cbr {

// How far rigid motions of the interface are from costing no force.
void judge_reduced_rigid(Reduction& r, const Superelement& s);

// Of Craig-Bampton's form. M_res: residual_mass_factor().
void add_accuracy(Reduction& r, const SparseCholesky& factor, const InterfaceMotions& motions,
                  const Matrix& Phi, const Cholesky& M_res, Superelement& s);

// Of Craig-Bampton's form, from which s is to go over to another basis: what is known of it, and
// its lowest free modes.
FreeEigenvalues look_before(Reduction& r, const SparseCholesky& factor, const Matrix& Phi,
                            Superelement& s);
// And of the basis that it became, whose elastic eigenvalues come after the rigid ones.
void look_after(const FreeEigenvalues& free, Index n_rigid, Superelement& s);

// What the fixed-interface modes leave out, and by how much the lowest frequencies are off: those
// of the full component, `free`, are known.
void add_accuracy_of_shapes(Reduction& r, const SparseCholesky& factor,
                            const FixedInterfaceModes& modes, const Vector& free, Superelement& s);

}  // namespace cbr
