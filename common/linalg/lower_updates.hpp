// SPDX-License-Identifier: GPL-3.0-or-later
// Updates and factors of the lower triangle of a symmetric matrix, in tiles that our threads share.
#pragma once

#include <algorithm>
#include <functional>

#include "common/base/types.hpp"

namespace cbr {

// Sides of one thread's tile.
constexpr Index update_tile = 256;
constexpr Index update_tiles(Index n) { return (n + update_tile - 1) / update_tile; }

// A - L L^T on the lower triangle   (A: m x m, L: m x k). `share`: by all threads, each with a BLAS
// of one.
void subtract_square(const Eigen::Ref<const Matrix>& L, bool share, Eigen::Ref<Matrix> A);
// A - W Y^T - Y W^T on the lower triangle   (A: m x m; W, Y: m x k)
void subtract_pair(const Eigen::Ref<const Matrix>& W, const Eigen::Ref<const Matrix>& Y, bool share,
                   Eigen::Ref<Matrix> A);

// Factors F_1 = L_1 L_1^T, the square top of F, and sets L_2 = F_2 L_1^-T below it, in place. All
// threads work, each with a BLAS of one. Entries above the diagonal stay. False: F_1 is not
// positive definite.
bool factor_columns(Eigen::Ref<Matrix> F);
// A <- L^-1 A L^-T of a symmetric A, in place, by all threads. Reads both lower triangles and
// writes A's alone. Half the cost of two divisions of a whole A.
void divide_both_sides(const Matrix& L, Eigen::Ref<Matrix> A);
// Rows of a square from which on both gain.
constexpr Index worth_tiles = 1024;

// task(i) for i < n: on all threads where they share, else in order on this one.
void share_tasks(Index n, bool share, const std::function<void(Index)>& task);

// use(column) for each of n columns: runs of them on all threads where they share, else in order on
// this one.
template <typename Use>
void share_columns(Index n, bool share, const Use& use) {
  constexpr Index run = 32;
  share_tasks((n + run - 1) / run, share, [&](Index i) {
    for (Index j = i * run; j < std::min(n, (i + 1) * run); ++j) use(j);
  });
}

}  // namespace cbr
