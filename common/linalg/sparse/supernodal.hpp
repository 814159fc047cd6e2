// SPDX-License-Identifier: GPL-3.0-or-later
// Triangular solves with a supernodal Cholesky factor, on panels of right-hand sides that are
// stored by rows.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// P A P^T = L L^T by supernodes, in postorder. Columns super[s] .. super[s + 1] - 1 of L share the
// rows rows[pi[s]] .. rows[pi[s + 1] - 1], first these columns themselves. Their values follow
// column by column from x[px[s]] on (x is null: the pattern alone). A view, which owns nothing.
struct SupernodalFactor {
  Index n = 0, n_super = 0;
  const Index *super = nullptr, *pi = nullptr, *px = nullptr, *rows = nullptr;
  const Index* order = nullptr;  // n: the row of A that is eliminated as the i-th
  const double* x = nullptr;

  Index first(Index s) const { return super[s]; }
  Index columns(Index s) const { return super[s + 1] - super[s]; }
  Index height(Index s) const { return pi[s + 1] - pi[s]; }
  // From one column's values to the next's: the height, or more where rows at the end belong to no
  // view.
  Index stride(Index s) const { return (px[s + 1] - px[s]) / columns(s); }
};

// Supernodes that a solve visits, in ascending order, and its cost.
struct SupernodeSet {
  std::vector<Index> supernodes;
  double flops_per_column = 0;  // of a forward or of a backward solve
};

// The elimination tree of the supernodes.
class SupernodeTree {
 public:
  SupernodeTree() = default;
  explicit SupernodeTree(const SupernodalFactor& factor);

  const SupernodalFactor& factor() const { return factor_; }
  // Rows in the order of elimination -> the supernodes that hold them and all their ancestors. L^-1
  // b vanishes elsewhere if b has only these rows. These rows of L^-T y need no others (Gilbert,
  // Liu 1993, doi 10.1137/0614019).
  SupernodeSet reach(const std::vector<Index>& rows) const;
  const SupernodeSet& all() const { return all_; }
  Index parent(Index s) const { return parent_[s]; }  // -1: a root

  // Solves with diagonal blocks of L use the inverses of their diagonal tiles, as products run at
  // three times the rate of dtrsm on few columns. A triangular inverse leaves a residual as small
  // as substitution does (Higham 2002, 14.2).
  static constexpr Index tile = 32;
  // L_tt^-1 of the tile that begins with this column of L, `tile` apart from the supernode's first
  // (leading dimension tile)
  const double* inverse(Index column) const { return inverse_.col(column).data(); }

 private:
  void invert_tiles();

  SupernodalFactor factor_;
  Matrix inverse_;                   // tile x n
  std::vector<Index> supernode_of_;  // per column
  std::vector<Index> parent_;        // per supernode, -1: a root
  SupernodeSet all_;
};

// Solves of one thread, with its workspace. Panels are transposed, X^T (width x n), with columns in
// the order of elimination, so that a row of X is contiguous. Gathers and scatters copy whole
// lines, and every supernode is a few products of tiles and one dgemm.
class PanelSolver {
 public:
  PanelSolver(const SupernodeTree& tree, Index width);

  // X <- L^-1 X. Supernodes outside the set are neither read nor written, and X must be zero there.
  // Panels of narrow::width rows with that stride bypass BLAS when the solver's width is
  // narrow::width too; unwanted rows are allowed.
  void forward(Eigen::Ref<Matrix> X_t, const SupernodeSet& set);
  // X <- L^-T X on the supernodes of the set, which must hold the ancestors of each; X is not
  // touched elsewhere.
  void backward(Eigen::Ref<Matrix> X_t, const SupernodeSet& set);

 private:
  void solve_diagonal(Index s, Eigen::Ref<Matrix> X_t);
  void fetch(Index s) const;
  void narrow_forward(Index s, double* X_t);
  void narrow_backward(Index s, double* X_t);
  void solve_diagonal_transposed(Index s, Eigen::Ref<Matrix> X_t);

  const SupernodeTree& tree_;
  const SupernodalFactor& factor_;
  Matrix work_;  // width x the longest part of a supernode below its diagonal block
};

// X^T <- B permuted, and back: column i of X^T is row order[i] of B   (n x w)
void load_panel(const SupernodalFactor& factor, const Eigen::Ref<const Matrix>& B,
                Eigen::Ref<Matrix> X_t);
void store_panel(const SupernodalFactor& factor, const Eigen::Ref<const Matrix>& X_t,
                 Eigen::Ref<Matrix> B);

}  // namespace cbr

// Parts of a supernode's triangular solves with eight right-hand sides. X^T is narrow::width x n,
// in the order of elimination. Columns and rows are counted from the supernode's first. For the
// .cpp of this folder.
namespace cbr::narrow {

// X <- L_bb^-1 X of the columns begin ... end, and X <- L_bb^-T X. work: as many columns of X^T.
void solve_columns(const SupernodeTree& tree, Index s, Index begin, Index end, double* X_t,
                   double* work);
void solve_columns_transposed(const SupernodeTree& tree, Index s, Index begin, Index end,
                              double* X_t, double* work);

// X_rows <- X_rows - L X_columns. work: as many columns of X^T as there are rows.
void subtract_rows(const SupernodalFactor& factor, Index s, Index begin, Index end, Index first_row,
                   Index last_row, double* X_t, double* work);
// X_columns <- X_columns - L^T X_rows
void subtract_rows_transposed(const SupernodalFactor& factor, Index s, Index begin, Index end,
                              Index first_row, Index last_row, double* X_t, double* work);

}  // namespace cbr::narrow
