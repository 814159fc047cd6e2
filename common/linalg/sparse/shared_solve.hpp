// SPDX-License-Identifier: GPL-3.0-or-later
// A few right-hand sides at a time, solved for by several threads: each takes subtrees of the
// elimination tree, and all of them share the wide supernodes above.
#pragma once

#include <vector>

#include "common/base/threads.hpp"
#include "common/linalg/sparse/supernodal.hpp"

namespace cbr {

// Keeps its workspace, and so is for one caller at a time. The same number of threads gives the
// same bytes.
class SharedSolve {
 public:
  // A = L L^T, or L S L^T with the signs S (n, in the order of elimination).
  SharedSolve(const SupernodeTree& tree, int threads, Vector signs = {});
  SharedSolve(const SharedSolve&) = delete;
  SharedSolve& operator=(const SharedSolve&) = delete;

  // X <- A^-1 X   (n x m, m up to narrow::width)
  void operator()(Eigen::Ref<Matrix> X);

 private:
  // Supernodes of the top that follow each other.
  struct Run {
    std::size_t first, last;  // in top_; without the last
  };

  void share_out();
  void collect(const std::vector<int>& owner);
  void plan();
  void plan_forward(Index s);
  void plan_backward(Index s);
  std::vector<Run> runs(double least) const;
  double entries(Index s) const;

  void begin(std::size_t t);
  void end(std::size_t t);
  void gather(const Run& run);
  void load(Index s, Matrix& X_t, bool add) const;
  void store(Index s, const Matrix& X_t);
  void apply_signs(Index first, Index columns, Matrix& X_t) const;
  double* scratch(int thread) { return scratch_[thread].data(); }
  Matrix& main() { return panels_.front(); }

  const SupernodeTree& tree_;
  int threads_;
  Vector signs_;                   // or none
  std::vector<SupernodeSet> own_;  // of each thread
  std::vector<Index> top_;         // above all of these, ascending
  std::vector<Matrix> panels_;     // of each thread, narrow::width x n
  std::vector<PanelSolver> solvers_;
  std::vector<Matrix> scratch_;  // of each thread, narrow::width x the longest supernode
  PhasedWork work_;
  // Right-hand sides, overwritten by the solution
  double* X_ = nullptr;
  Index stride_ = 0, columns_ = 0;
};

}  // namespace cbr
