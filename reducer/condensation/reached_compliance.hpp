// SPDX-License-Identifier: GPL-3.0-or-later
// Compliance of a factored matrix at a few rows.
#pragma once

#include "common/base/types.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"

namespace cbr {

// B^T A^-1 B   (s x s), exactly symmetric, for B (n x s) with entries in few rows. Of L only the
// part is visited that these rows reach (Gilbert, Liu 1993, doi 10.1137/0614019), in panels with
// all threads. bytes: of the panels of all threads together.
Matrix reached_compliance(const SparseCholesky& factor_of_A, const SparseMatrix& B,
                          double bytes = 1e9);

}  // namespace cbr
