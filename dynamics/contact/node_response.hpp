// SPDX-License-Identifier: GPL-3.0-or-later
// How the end of a step answers impulses on contact nodes.
#pragma once

#include <memory>
#include <utility>

#include "common/types.hpp"

namespace cbr {

// S: change of end-of-step position (dof 3 i + c) per unit impulse at the start of the step, symmetric, 3 m x 3 m.
// A lumped mesh answers node by node: then only `diagonal` (3 m, scene axes) is filled, else only `block`.
struct NodeResponse {
  Vector diagonal;
  // In axes that instances of one component can share: S = (I x T) block (I x T)^T, T = axes, on each node's three dofs.
  std::shared_ptr<const Matrix> block;
  Matrix3 axes = Matrix3::Identity();

  bool is_diagonal() const { return !block; }
  bool empty() const { return !block && diagonal.size() == 0; }
  Index n_dofs() const { return block ? block->rows() : diagonal.size(); }
  void set_block(Matrix S) { block = std::make_shared<const Matrix>(std::move(S)); }
  Matrix dense() const;                                // S in scene axes, a copy
  void add_product(const Points& p, Points& x) const;  // x += S p   (m x 3 both), over the nodes whose p is not 0
};

}  // namespace cbr
