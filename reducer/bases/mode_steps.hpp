// SPDX-License-Identifier: GPL-3.0-or-later
// The fixed-interface modes of one reduction: which it computes, which of them it keeps, and what
// follows them.
#pragma once

#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/bases/reduction_steps.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"

namespace cbr {

// Modes that are known before the condensation; none where it decides about them, or the basis has
// free modes.
FixedInterfaceModes first_modes(Reduction& r, const SparseCholesky& factor);

// Of `pick: participation` those that are kept; r.not_kept has the others.
void keep_modes(Reduction& r, FixedInterfaceModes& modes, Condensation& condensed);

// Of the modes that are kept, ascending: r.lowest.
void keep_lowest(Reduction& r, const Matrix& Phi);

// Motions of the interface that the errors are told of (is_judged) or that a tolerance needs.
InterfaceMotions motions_to_judge(Reduction& r, const SparseCholesky& factor, bool is_judged,
                                  const Superelement& s);

// The modes that option `tolerance` needs and residual vectors of loads inside; then s takes M_kc
// and the eigenvalues. InputError: a mass that is lost in round-off.
void complete_modes(Reduction& r, const SparseCholesky& factor, const InterfaceMotions& motions,
                    FixedInterfaceModes& modes, Condensation& condensed, Superelement& s);

// M_kc, the eigenvalues and the highest frequency, of modes that are complete.
void take_matrices(Reduction& r, const FixedInterfaceModes& modes, Condensation& condensed,
                   Superelement& s);

}  // namespace cbr
