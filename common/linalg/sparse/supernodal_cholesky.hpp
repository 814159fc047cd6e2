// SPDX-License-Identifier: GPL-3.0-or-later
// L L^T by supernodes, front by front on all threads.
#pragma once

#include "common/linalg/sparse/fronts.hpp"

namespace cbr {

// Fills x (px[n_super] numbers, laid out as the tree's factor says) with P A P^T = L L^T. Both
// triangles of A (n x n) are stored, where the tree's factor has entries. Returns the number of the
// first pivot that is not positive, in the order of elimination, or n. Fronts before it are valid;
// one begins at `boundary`. Needs at most front_bytes() a thread beside x.
Index factor_supernodes(const SupernodeTree& tree, const SparseMatrix& A, Index boundary, double* x,
                        const Progress& progress = {});

// Factors the first n_I columns alone, which begin a supernode: L of K_II with its rows of C.
// Condenses K and M to C front by front, with dense matrices. K_cc = K_CC - K_CI K_II^-1 K_IC and
// M_cc = T^T M T, T = [-K_II^-1 K_IC; 1], in the tree's order   (c x c, lower triangles). M must
// have no entry where K has none. Needs front_bytes() twice.
// False: K_II is not positive definite, or M has such an entry.
bool factor_and_condense(const SupernodeTree& tree, Index n_I, const SparseMatrix& K,
                         const SparseMatrix& M, double* x, Matrix& K_cc, Matrix& M_cc,
                         const Progress& progress = {});

// Flops of it, beyond those of the factor's own columns, for a front of so many columns and rows
// below.
double condensing_flops(double columns, double below);

}  // namespace cbr
