// SPDX-License-Identifier: GPL-3.0-or-later
// L L^T by supernodes, front by front on all threads.
#pragma once

#include "common/linalg/sparse/fronts.hpp"

namespace cbr {

enum class Factored { done, not_definite, foreign };

// Fills x (px[n_super] numbers, laid out as the tree's factor says) with P A P^T = L L^T.
// `foreign`: A has an entry where the tree's factor has none. x is invalid unless done. Needs at
// most front_bytes() a thread beside x.
Factored factor_supernodes(const SupernodeTree& tree, const ShiftedMatrix& A, double* x,
                           const Progress& progress = {});

// Factors the first n_I columns alone, which begin a supernode: L of K_II with its rows of C.
// Condenses K and M to C front by front, with dense matrices. K_cc = K_CC - K_CI K_II^-1 K_IC and
// M_cc = T^T M T, T = [-K_II^-1 K_IC; 1], in the tree's order   (c x c, lower triangles). M must
// have no entry where K has none. Needs front_bytes() twice.
Factored factor_and_condense(const SupernodeTree& tree, Index n_I, const SparseMatrix& K,
                             const SparseMatrix& M, double* x, Matrix& K_cc, Matrix& M_cc,
                             const Progress& progress = {});

// Flops of it, beyond those of the factor's own columns, for a front of so many columns and rows
// below.
double condensing_flops(double columns, double below);

}  // namespace cbr
