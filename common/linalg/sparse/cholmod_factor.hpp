// SPDX-License-Identifier: GPL-3.0-or-later
// CHOLMOD's factor: its order of elimination, cut to supernodes of our width, filled front by front
// on all threads or by CHOLMOD. The only code that includes cholmod.h is cholmod_factor.cpp.
#pragma once

#include <memory>
#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/progress.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "common/linalg/sparse/supernodal.hpp"

namespace cbr {

bool has_both_triangles(const SparseMatrix& A);

// RunError: not enough memory, with the size of the workspace.
[[noreturn]] void fail_to_solve(Index rows, Index columns);

// Matrices are compressed, and their lower triangle is read, if nothing else is said. RunError when
// memory does not suffice.
class CholmodFactor {
 public:
  enum class Kind { simplicial, supernodal };
  explicit CholmodFactor(Kind kind);
  ~CholmodFactor();

  // The cheapest order of elimination on the graph of nodes (or of rows), and the symbolic factor
  // of A. `last`, `nodes`: as of SparseCholesky.
  void analyze(const SparseMatrix& A, const std::vector<Index>& last = {},
               std::vector<Index> nodes = {});
  void factorize(const SparseMatrix& A, const std::vector<Index>& last, const Progress& progress,
                 const std::vector<Index>& nodes);
  // The columns before `last`, and K and M condensed to `last`. False: not done, for one of the
  // reasons of SparseCholesky::condensing().
  bool condense(const SparseMatrix& K, const SparseMatrix& M, const std::vector<Index>& last,
                Condensed& condensed, bool always, const Progress& progress);

  Index n() const;
  Index n_done() const;  // columns before the first pivot that is not positive; n(): all
  double n_nonzeros() const;
  double flops() const;
  double bytes() const;
  SupernodalFactor view() const;
  const Index* permutation() const;
  const Index* column_counts() const;  // of L, after analyze()

  // One right-hand side; b and x may be the same. The workspaces are kept.
  void solve(const double* b, double* x);

 private:
  void analyze_rows(const SparseMatrix& A);
  bool cut(Index widest, Index boundary);
  void make_room(const SparseMatrix& A);
  bool factorize_by_fronts(const SparseMatrix& A, const Progress& progress);
  bool is_cheaper(Index n_I, double& more_flops) const;
  void check(const char* phase, const SparseMatrix& A) const;

  struct Handles;
  std::unique_ptr<Handles> h_;
};

}  // namespace cbr
