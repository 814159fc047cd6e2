// SPDX-License-Identifier: GPL-3.0-or-later
// How the end of a step answers impulses on contact nodes.
#pragma once

#include "common/types.hpp"

namespace cbr {

// S: change of end-of-step position (dof 3 i + c) per unit impulse at the start of the step, symmetric.
// A lumped mesh answers node by node: then only `diagonal` (3 m) is filled, else only `dense` (3 m x 3 m).
struct NodeResponse {
  Vector diagonal;
  Matrix dense;
  bool is_diagonal() const { return dense.size() == 0; }
};

}  // namespace cbr
