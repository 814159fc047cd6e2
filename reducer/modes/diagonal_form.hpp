// SPDX-License-Identifier: GPL-3.0-or-later
// K^ V = M^ V diag(omega^2), V^T M^ V = I: the superelement as oscillators of their own.
#pragma once

#include <vector>

#include "common/linalg/dense.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/condensation/superelement_algebra.hpp"

namespace cbr {

// Sets omega and V. `part` (one per superelement node): which connected part of the component the
// node belongs to; each part has six rigid motions. Their omega is exactly 0 and their columns of V
// are the analytic motions [0; R_c], orthonormalised in M^, so that a free body keeps its momentum
// to round-off; the elastic columns are re-orthogonalised against them. Signs fixed. Returns the
// number of rigid motions. InputError when M^ is not positive definite. M_res:
// residual_mass_factor() of it, or null: to be made.
Index add_diagonal_form(Superelement& superelement, const std::vector<Index>& part,
                        const Cholesky* M_res = nullptr);
// The same with rigid motions R (n x r, independent columns) as they are.
void add_diagonal_form(Superelement& superelement, Matrix R);

// Computes only the rigid motions and the `count` lowest columns beyond them (all, where there are
// fewer) of the diagonal form: omega (m) and V (n x m). For estimates: it is no diagonal form for
// other uses. By block Lanczos where that is cheaper and the definiteness of K^ - sigma M^ confirms
// the count of modes below; else all are computed.
Index add_lowest_modes(Superelement& superelement, const std::vector<Index>& part, Index count);

}  // namespace cbr
