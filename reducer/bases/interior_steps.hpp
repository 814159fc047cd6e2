// SPDX-License-Identifier: GPL-3.0-or-later
// The interior of one reduction: K_II factored, and condensed onto the interface.
#pragma once

#include <optional>

#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/bases/reduction_steps.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/modes/free_factor.hpp"

namespace cbr {

// Fronts, or a Lanczos basis, have left room in the heap that may be needed as one piece elsewhere.
void return_room();

// Whether the condensation may come with the factorisation: nothing reads Psi, nobody asks for a
// way.
bool may_condense_by_fronts(const Reduction& r);

struct FactorAndCondensed {
  SparseCholesky factor;
  std::optional<Condensed> condensed;  // what came with the factorisation
};

// These three: InputError: K_II is singular.
SparseCholesky factorise(Reduction& r);
// Drops K and M of the model where no later step reads them.
FactorAndCondensed factorise_and_condense(Reduction& r);
// Of the free component, n_forces of which get their answers.
FreeFactor factorise_free(Reduction& r, const FreeComponent& model, Index n_forces);

// `by_fronts`: what came with the factorisation, or none. Phi: fixed-interface modes   (n_I x k)
Condensation condense_with(Reduction& r, const SparseCholesky& factor, const Matrix& Phi,
                           std::optional<Condensed>&& by_fronts);

// M_kc by the Psi that K_cc and M_cc are made with, of modes that were not known then.
void couple_again(Reduction& r, const SparseCholesky& factor, const Matrix& Phi, const Matrix& M_cc,
                  Condensation& condensed);

// Psi of the interior, column by column   (n_I x c)
Matrix constraint_modes(const Reduction& r, const SparseCholesky& factor);

}  // namespace cbr
