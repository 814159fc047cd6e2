// SPDX-License-Identifier: GPL-3.0-or-later
// How much memory constraint modes may take.
#pragma once

#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

// Value of `memory` 0: half of this machine's, in bytes.
double half_of_memory();
// InputError when K_cc and M_cc of c interface dofs, dense, need more than `memory` bytes.
void require_memory_for_interface(Index c, double memory);
// Bytes for panels of constraint modes: `given`, or for 0 half of this machine's. Less when the
// factor leaves too little memory. A panel of useful width takes 16 n_I bytes a column and thread.
double panel_memory(double given, const Partition& p, const SparseCholesky& factor,
                    const Matrix& Phi);

}  // namespace cbr
