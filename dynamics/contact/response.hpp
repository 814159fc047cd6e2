// SPDX-License-Identifier: GPL-3.0-or-later
// The response W of the gaps to contact impulses.
#pragma once

#include <vector>

#include "dynamics/contact/contact_surface.hpp"

namespace cbr {

// One of the two is filled: `sparse` when every body answers node by node and there are many constraints, else `dense`.
struct GapResponse {
  Matrix dense;         // m x m
  SparseMatrix sparse;  // m x m, both triangles
  bool is_sparse = false;
  Index size() const { return is_sparse ? sparse.rows() : dense.rows(); }
};

// W = G S G^T (m x m): change of the gaps at the end of the step per unit impulse; S of all bodies' contact nodes.
// Row i of G: normal on the slave node, -weights x normal on the master nodes.
GapResponse gap_response(const std::vector<Constraint>& constraints, const std::vector<ContactBody>& bodies);

// W p.
Vector apply(const GapResponse& W, const Vector& p);

// Adds G^T p to the bodies' impulses.
void spread_impulses(const std::vector<Constraint>& constraints, const Vector& p, std::vector<ContactBody>& bodies);

// Whether two lists have the same nodes, weights and normals, so that W and its factor can be kept (`tolerance` absolute, on
// numbers of the order of one).
bool same_rows(const std::vector<Constraint>& a, const std::vector<Constraint>& b, double tolerance);

}  // namespace cbr
