// SPDX-License-Identifier: GPL-3.0-or-later
// Elimination of a sparse symmetric matrix front by front: multifrontal (Duff, Reid 1983,
// doi 10.1145/356044.356047), dense products throughout.
#pragma once

#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/lower_updates.hpp"
#include "common/linalg/sparse/supernodal.hpp"

namespace cbr {

// K - sigma M, never formed; M null: K. Symmetric, both triangles stored.
struct ShiftedMatrix {
  const SparseMatrix& K;
  double sigma = 0;
  const SparseMatrix* M = nullptr;

  // use(row, value) for the entries of a column; one that both matrices have comes twice, in parts.
  template <typename Use>
  void each(Index column, const Use& use) const {
    for (SparseMatrix::InnerIterator it(K, column); it; ++it) use(it.row(), it.value());
    if (M == nullptr) return;
    for (SparseMatrix::InnerIterator it(*M, column); it; ++it) use(it.row(), -sigma * it.value());
  }
};

// Columns that are eliminated together, and the rows that they share: whole supernodes, of which
// the first is `supernode`.
struct Front {
  Index first = 0, columns = 0, height = 0;
  const Index* rows = nullptr;
  Index parent = -1;  // a front, -1: none
  Index supernode = 0, n_supernodes = 0;
  bool is_kept = false;  // its columns are not pivots
  Index below() const { return height - columns; }
};

// A front's part of one matrix. F (height x columns, lower): columns of the matrix less the updates
// of earlier pivots. `rest` (below x below, lower triangle): the Schur complement for the parent.
struct FrontMatrix {
  Matrix F, rest;
};

// Fronts in the order of the tree. Subtrees run in parallel, each on one thread; the fronts above
// follow one by one with BLAS's threads. Neither the work nor its order depends on the number of
// threads. A derived class eliminates the pivots.
class Fronts {
 public:
  // All must outlive the object; the matrices are permuted as the tree's factor is. At column
  // `boundary`, the first of a supernode, a front begins. keeps_last: from there on columns are no
  // pivots, and are only collected.
  Fronts(const SupernodeTree& tree, std::vector<ShiftedMatrix> matrices, Index boundary,
         bool keeps_last, const Progress& progress = {});
  virtual ~Fronts() = default;
  Fronts(const Fronts&) = delete;
  Fronts& operator=(const Fronts&) = delete;

 protected:
  // stopped: eliminate() said no; foreign: A has an entry where the tree has none
  enum class Outcome { done, stopped, foreign };
  // one_by_one: no front before those that precede it.
  Outcome run(bool one_by_one = false);

  const SupernodalFactor& factor() const { return f_; }
  const ShiftedMatrix& matrix() const { return matrices_.front(); }
  // Subtracts these pivots' updates from each matrix' `rest`, or collects kept columns. False stops
  // the factorisation. Several threads call it, except for a front that is `alone`: it is large,
  // and all threads are free.
  virtual bool eliminate(const Front& front, std::vector<FrontMatrix>& of, bool alone) = 0;

 private:
  struct Subtree {
    Index first, last;
  };

  bool fine() const { return !stopped_ && !foreign_; }
  Index n_fronts() const { return static_cast<Index>(fronts_.size()); }
  void eliminate_subtrees(std::size_t first, std::size_t last);
  void plan();
  void front(Index s, std::vector<Index>& position, bool alone);
  void assemble(const ShiftedMatrix& A, Index first, const std::vector<Index>& position, Matrix& F);
  void extend_add(Index child, const std::vector<Index>& position, bool alone,
                  std::vector<FrontMatrix>& of);

  const SupernodalFactor& f_;
  std::vector<Front> fronts_;  // children before their parents
  std::vector<ShiftedMatrix> matrices_;
  std::vector<Index> place_;                  // in the order of elimination, of each row of A
  std::vector<std::vector<Index>> children_;  // per front, ascending
  std::vector<std::vector<Matrix>> updates_;  // lower triangles, per front and matrix
  std::vector<Subtree> subtrees_;
  std::vector<Index> top_;
  std::atomic<bool> stopped_{false}, foreign_{false};
  Progress progress_;  // reported by the thread that runs
  std::thread::id runs_;
  double all_flops_ = 0;
  std::atomic<double> done_flops_{0};
};

// Bytes that the fronts of one matrix take at the most, one thread working.
double front_bytes(const SupernodeTree& tree);

// --- L L^T by supernodes, front by front on all threads ---

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

// --- P A P^T = L D L^T by supernodes, D diagonal ---
//
// The order is the tree's; within a front, where a pivot would be small, larger ones of its
// neighbours come first. Multifrontal (Duff, Reid 1983, doi 10.1145/356044.356047): dense products
// throughout, subtrees in parallel. The figures and the work do not depend on the number of
// threads.

// Number of negative pivots; -1 when a pivot is below `vanishing` times |A_jj|. L is not kept.
// Nothing when A has an entry where the tree's factor has none.
std::optional<Index> count_negative_pivots(const SupernodeTree& tree, const ShiftedMatrix& A,
                                           double vanishing, const Progress& progress = {});

struct SignedPivots {
  Vector signs;              // of D, in the order of elimination   (n)
  std::vector<Index> order;  // the column of the tree that each pivot was, of the same front   (n)
  std::vector<Index> front_end;  // after the columns of its front, for each supernode
};

// The same, and L |D|^1/2 is kept, column by column of each supernode from x[px[s]] on.
std::optional<Index> factor_with_signs(const SupernodeTree& tree, const ShiftedMatrix& A,
                                       double vanishing, const Index* px, double* x,
                                       SignedPivots& pivots);

}  // namespace cbr
