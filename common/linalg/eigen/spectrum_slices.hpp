// SPDX-License-Identifier: GPL-3.0-or-later
// Hundreds and thousands of eigenpairs of a sparse pencil, slice by slice of its spectrum.
#pragma once

#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {

// Modes of a slice at the lowest cost each. The modes share one factorisation, and the cost of
// orthonormalisation grows as their square. n: rows, flops: of a factorisation.
Index slice_width(Index n, double flops);
// True when slices find k modes at a lower cost than one shift, which may find most in outline.
bool slices_pay(Index k, Index width, bool in_outline);

// The k lowest of K x = lambda M x, `width` of them from each shift (Grimes, Lewis, Simon 1994, doi
// 10.1137/S0895479888151111; factors of our own). `factor`: Cholesky of K, which finds the lowest.
// The negative pivots at each shift count the eigenvalues below it, hence the missing modes of each
// slice. Work and memory beside Phi grow with k, not with its square. converged: false when no
// shift finds the counted number, as where a multiple eigenvalue lacks copies: use another method.
// Phi comes without fixed signs. `known`: the lowest, as many as there are; the last few of them
// are found again.
Eigenpairs eigenpairs_by_slices(const SparseMatrix& K, const SparseMatrix& M,
                                const SparseCholesky& factor, Index k, Index width,
                                double tolerance, const Progress& progress,
                                const Eigenpairs& known = {});

}  // namespace cbr
