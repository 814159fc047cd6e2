// SPDX-License-Identifier: GPL-3.0-or-later
// A few right-hand sides at a time, solved for by several threads, each of which takes subtrees of
// the elimination tree.
#pragma once

#include <vector>

#include "common/linalg/sparse/supernodal.hpp"

namespace cbr {

// Keeps its workspace, and so is for one caller at a time. The same number of threads gives the
// same bytes.
class SharedSolve {
 public:
  // A = L L^T, or L S L^T with the signs S (n, in the order of elimination).
  SharedSolve(const SupernodeTree& tree, int threads, Vector signs = {});

  // X <- A^-1 X   (n x m, m up to narrow::width)
  void operator()(Eigen::Ref<Matrix> X);

 private:
  void share_out();
  void collect(const std::vector<int>& owner);
  void load(const SupernodeSet& set, const Eigen::Ref<const Matrix>& B, Matrix& X_t,
            bool add) const;
  void store(const SupernodeSet& set, const Matrix& X_t, Eigen::Ref<Matrix> B) const;

  void apply_signs(const SupernodeSet& set, Matrix& X_t) const;

  const SupernodeTree& tree_;
  int threads_;
  Vector signs_;                   // or none
  std::vector<SupernodeSet> own_;  // of each thread
  SupernodeSet top_;               // above all of these
  std::vector<Matrix> panels_;     // of each thread, narrow::width x n
  std::vector<PanelSolver> solvers_;
};

}  // namespace cbr
