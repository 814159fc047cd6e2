// SPDX-License-Identifier: GPL-3.0-or-later
// All eigenpairs of K x = lambda M x below a bound, where K^-1 and M are dense: few products count,
// the basis costs little.
#pragma once

#include <functional>

#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {

struct LanczosBelowOptions {
  Index block = 0;  // 0: chosen from n
  Index most = 0;   // vectors of the basis; 0: n / 4, of a small problem nearly n
  Index count = 0;  // ends when so many have converged, whatever the bound; 0: by the bound alone
  double tolerance = 1e-13;  // residual in the M-norm of a Ritz pair of K^-1 M, relative to its
                             // value, or the largest one's round-off
};

// Block Lanczos without restarts on K^-1 M, fully M-orthonormalised (Grimes, Lewis, Simon 1994, doi
// 10.1137/S0895479888151111). A vector costs one product with M and one with K^-1. multiply_M: M X;
// `solve` overwrites B by K^-1 B (n x q both). For a free body `solve` applies the elastic
// flexibility (rank n - n_rigid), which excludes rigid motions. Ends when an eigenvalue above
// `bound`, or options.count of them, have converged: lambda holds all that have, ascending.
// converged: false when the basis was full before, or a block became dependent. Copies of multiple
// eigenvalues may be missing, as with any Krylov method; only a count excludes that.
Eigenpairs lanczos_below(Index n, Index n_rigid,
                         const std::function<Matrix(const Eigen::Ref<const Matrix>&)>& multiply_M,
                         const std::function<void(Eigen::Ref<Matrix>)>& solve, double bound,
                         const LanczosBelowOptions& options = {});

}  // namespace cbr
