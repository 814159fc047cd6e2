// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/linalg/sparse: sparse factorisations.
//
// One sparse factorisation, used for everything.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/sparse/supernodal.hpp"

namespace cbr {

// K and M condensed statically to the dofs that are eliminated last   (c x c); flops beyond those
// of the factor.
struct Condensed {
  Matrix K, M;
  double flops = 0;
};

// A = P^T L L^T P of a symmetric positive definite matrix, supernodal, front by front. The order is
// nested dissection (METIS) or minimum degree on the graph of nodes (symbolic_factor.hpp). The same
// matrix gives the same factor on any number of threads. One object is for one thread at a
// time.
class SparseCholesky {
 public:
  // Only the lower triangle of A (n x n) is read. Not positive definite is a result, not an
  // exception: ask ok(). RunError when memory does not suffice, with the size of the factor. The
  // rows `last` (ascending, whole nodes) are eliminated after all others, so that leading() is a
  // factor of these. `nodes`: an order of the nodes outside `last` that is known (factor_cost), or
  // none.
  explicit SparseCholesky(const SparseMatrix& A, const std::vector<Index>& last = {},
                          const Progress& progress = {}, const std::vector<Index>& nodes = {});
  // The factor of A without the rows `last`: the first columns of this one, of which it takes the
  // memory, not a copy. It may be fine where this one is not, as rows outside `last` come first.
  SparseCholesky leading() const;
  // leading() of K without factoring the rows `last`, and K and M condensed to them (Guyan 1965,
  // doi 10.2514/3.2874). Condensed: T^T K T and T^T M T with T = [-K_II^-1 K_IC; 1]   (c x c,
  // symmetric). K and M: n x n, both triangles stored. None when solves of the constraint modes
  // cost less (by flops, unless `always`), or memory is too small for the fronts. None also when
  // K_II is not positive definite, or M has an entry where K has none.
  static std::optional<SparseCholesky> condensing(const SparseMatrix& K, const SparseMatrix& M,
                                                  const std::vector<Index>& last,
                                                  Condensed& condensed, bool always = false,
                                                  const Progress& progress = {});
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  bool ok() const;
  // min over the columns of L_jj^2 / A_jj, the pivot relative to the diagonal of A, and its column.
  // Independent of units and of stiffness ratios between parts, hence a test for a singular A that
  // passed by round-off (below 1e-13). Not ok(): 0, and the column whose pivot was not positive.
  double smallest_pivot() const;
  Index weakest_column() const;
  Index n_rows() const;
  double n_nonzeros() const;  // of L
  double bytes() const;       // of memory: with the unused entries of its rectangles
  double flops() const;       // of the factorisation

  Matrix solve(const Matrix& B) const;              // A X = B, n x m
  void solve_in_place(Eigen::Ref<Matrix> B) const;  // in blocks of right-hand sides
  // Workspace kept between calls: for ARPACK's many single right-hand sides. b and x may be the
  // same.
  void solve(const double* b, double* x) const;

  // For those who keep their right-hand sides as panels of the factor's order: constraint modes.
  const SupernodeTree& tree() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Costs of SparseCholesky, estimated from the pattern alone. `nodes` (n x n, lower triangle with
// its diagonal, values ignored) has an entry where two nodes share an element. Each node stands for
// `dofs` columns that all meet. The order of elimination is that of the nodes, so that the figures
// may differ by some percent from a factorisation's.
struct FactorCost {
  double n_nonzeros = 0, flops = 0;
  std::vector<Index> order{};  // of the nodes, by which it was counted
};
FactorCost factor_cost(const SparseMatrix& nodes, Index dofs);

// Number of negative pivots of L D L^T = A, by Sylvester the number of eigenvalues below zero. -1
// when a pivot vanished: shift sigma of A = K - sigma M a little. Then sigma is an eigenvalue (to
// round-off), or the order of elimination met a singular leading part. Costs about as much as a
// factorisation. Both triangles are stored. `like`: factor of a matrix with (at least) the pattern
// of A, for its order of elimination. Where A has an entry that `like` lacks, a new order is found.
Index negative_inertia(const SparseMatrix& A, const SparseCholesky* like = nullptr);
// Of K - sigma M, which is not formed with a `like` that serves.
Index negative_inertia(const SparseMatrix& K, double sigma, const SparseMatrix& M,
                       const SparseCholesky& like, const Progress& progress = {});

}  // namespace cbr
