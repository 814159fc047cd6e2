// SPDX-License-Identifier: GPL-3.0-or-later
// One factorisation of a free component that serves for its interior, its interface held, too.
#pragma once

#include <optional>

#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

// A component's own matrices. K has springs for a while, and is restored in the end.
struct FreeComponent {
  SparseMatrix& K;        // N x N
  const SparseMatrix& M;  // N x N
  const Points& x;        // of its nodes
  Index n_rotations = 0;  // of these the last, which are rotations of shells
};

struct FreeFactor {
  Matrix N, P;  // N x 6: rigid motions, N^T M N = 1, and P = M N
  // of K with springs at six dofs of the interface, which hold the rigid motions
  SparseCholesky whole;
  // of K_II, in the memory of the other; none: the interface is not eliminated last
  std::optional<SparseCholesky> interior;
};

// Its cost, from the factor of the interior's stiffness alone. Of a component with n_ratio times
// the interior's dofs and c interface dofs, n_forces forces on these.
struct FreeFactorCost {
  double flops = 0, forces_flops = 0;  // of the factorisations, of the answers to the forces
  bool is_one_factor = false;          // with the interface last; else two, of K and of K_II
  double all_flops() const { return flops + forces_flops; }
};
FreeFactorCost free_factor_cost(const FactorCost& interior, double n_ratio, Index c,
                                Index n_forces);

// Eliminates the interface last where that costs least, with the responses to `n_forces` forces on
// it: these need the last columns of the factor alone. `whole` is not ok() where K has other null
// vectors than rigid motions.
FreeFactor free_factor(const FreeComponent& model, const Partition& p, Index n_forces,
                       const Progress& progress = {});

}  // namespace cbr
