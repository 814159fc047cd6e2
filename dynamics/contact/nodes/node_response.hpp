// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/nodes: response of one body's nodes to contact impulses.
//
// Response of the end of a step to impulses on contact nodes.
#pragma once

#include <memory>
#include <utility>

#include "common/base/types.hpp"
#include "dynamics/contact/nodes/thin_response.hpp"

namespace cbr {

// S: change of end-of-step position (dof 3 i + c) per unit impulse at the start of the step,
// symmetric, 3 m x 3 m. One of three forms is filled. Nodes of a lumped mesh are independent:
// `diagonal` (3 m, scene axes).
struct NodeResponse {
  Vector diagonal;
  // In axes of the component, so that its instances can share it: S = (I x T) block (I x T)^T, T =
  // axes, on each node's three dofs. `thin` likewise.
  std::shared_ptr<const Matrix> block;
  std::shared_ptr<const ThinResponse> thin;
  Matrix3 axes = Matrix3::Identity();

  bool is_diagonal() const { return !block && !thin; }
  bool empty() const { return is_diagonal() && diagonal.size() == 0; }
  Index n_dofs() const { return block ? block->rows() : thin ? thin->n_dofs() : diagonal.size(); }
  // Whether some direction of the node has residual compliance, so that forces move it without
  // inertia.
  bool is_static(Index node) const {
    return thin && thin->rows->first[node] < thin->rows->first[node + 1];
  }
  void set_block(Matrix S) { block = std::make_shared<const Matrix>(std::move(S)); }
  Matrix dense() const;  // S in scene axes, a copy
  // x += S p   (m x 3 both), over the nodes with p != 0
  void add_product(const Points& p, Points& x) const;
};

}  // namespace cbr
