// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/exchange/reduced_matrices.hpp"

#include <algorithm>

#include "common/base/error.hpp"

namespace cbr {

ReducedMatrices reduced_matrices(const Superelement& s, Index first_modal_node) {
  if (s.basis != "craig-bampton") {
    throw InputError("basis " + s.basis +
                     " found, but only craig-bampton has mass and stiffness matrices of the "
                     "interface's dofs: reduce with basis: craig-bampton");
  }
  ReducedMatrices reduced;
  const Index c = s.c(), k = s.k();
  reduced.K = Matrix::Zero(c + k, c + k);
  reduced.M = Matrix::Identity(c + k, c + k);
  reduced.K.topLeftCorner(c, c) = s.K_cc;
  reduced.K.diagonal().tail(k) = s.eigenvalues;
  reduced.M.topLeftCorner(c, c) = s.M_cc;
  reduced.M.bottomLeftCorner(k, c) = s.M_kc;
  reduced.M.topRightCorner(c, k) = s.M_kc.transpose();
  for (Index i = 0; i < c; ++i) {
    const Index node = s.dof_node[static_cast<std::size_t>(i)];
    reduced.rows.push_back({s.node_ids[static_cast<std::size_t>(node)],
                            s.dof_component[static_cast<std::size_t>(i)] + 1,
                            s.coordinates.row(node).transpose(), 0});
  }
  const Index last =
      s.node_ids.empty() ? 0 : *std::max_element(s.node_ids.begin(), s.node_ids.end());
  if (first_modal_node == 0) first_modal_node = last + 1;
  if (first_modal_node <= last)
    throw InputError("--first-modal-node " + std::to_string(first_modal_node) +
                     " found, expected above " + std::to_string(last) +
                     ", the interface's largest node");
  for (Index j = 0; j < k; ++j) {
    reduced.rows.push_back({first_modal_node + j, 0, Vector3::Zero(), s.eigenvalues(j)});
  }
  return reduced;
}

}  // namespace cbr
