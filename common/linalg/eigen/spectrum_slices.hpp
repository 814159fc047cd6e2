// SPDX-License-Identifier: GPL-3.0-or-later
// Hundreds and thousands of eigenpairs of a sparse pencil, slice by slice of its spectrum.
#pragma once

#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {

// Modes of a slice that cost least each: a factorisation, which all of them share, against products
// that keep their basis orthonormal, which grow as their square. n: rows, flops: of a
// factorisation.
Index slice_width(Index n, double flops);
// Whether k modes cost less in slices than from one shift, which may find most of them in outline.
bool slices_pay(Index k, Index width, bool in_outline);

// The k lowest of K x = lambda M x, `width` of them from each shift (Grimes, Lewis, Simon 1994,
// doi 10.1137/S0895479888151111; factors of our own). `factor`: Cholesky of K,
// which finds the lowest. Each shift tells by its negative pivots how many eigenvalues are below
// it, so that each slice knows how many it has to find down to the last. Work and memory beside Phi
// grow with k, not with its square. converged is false when no shift gives what was counted, as
// where eigenvalues of a high multiplicity have copies missing: then another method must answer.
// Phi comes without fixed signs. `known`: the lowest, as many as there are; the last few of them
// are found again.
Eigenpairs eigenpairs_by_slices(const SparseMatrix& K, const SparseMatrix& M,
                                const SparseCholesky& factor, Index k, Index width,
                                double tolerance, const Progress& progress,
                                const Eigenpairs& known = {});

}  // namespace cbr
