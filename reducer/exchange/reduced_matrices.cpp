// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/exchange/reduced_matrices.hpp"

#include <algorithm>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

constexpr double round_off = 1e-14;  // of the largest compliance

// Residual compliance as residual vectors: B F B^T = R R^T / stiffness, R (c x r). The stiffness is
// that of the highest mode, so that K keeps its condition.
Matrix residual_vectors(const Superelement& s, double stiffness) {
  if (s.is_massless()) {
    const SymmetricEigen F = symmetric_eigen(s.massless.F);
    return F.vectors * (stiffness * F.values.cwiseMax(0)).cwiseSqrt().asDiagonal();
  }
  const StaticShare& statics = s.characteristic.statics;
  if (!statics.levels.empty())
    throw InputError("its residual compliance of " + std::to_string(statics.size()) +
                     " forces is in levels, which have no residual vectors: reduce with fewer "
                     "surfaces in characteristic.statics");
  const SymmetricEigen F = symmetric_eigen(statics.F);
  Matrix B = Matrix::Zero(s.c(), statics.size());
  for (Index i = 0; i < s.c(); ++i)
    for (Index j = 0; j < statics.size(); ++j)
      if (statics.node[j] == s.dof_node[i]) B(i, j) = statics.direction(j, s.dof_component[i]);
  const Index r = (F.values.array() > round_off * F.values.maxCoeff()).count();
  return B * F.vectors.rightCols(r) * (stiffness * F.values.tail(r)).cwiseSqrt().asDiagonal();
}

// K = diag(eigenvalues, stiffness), M = diag(1, 0), T = [V, R]
void add_modal(const Superelement& s, ReducedMatrices& reduced) {
  const Matrix& V = s.is_massless() ? s.massless.V : s.characteristic.V;
  const double stiffness = s.eigenvalues.maxCoeff();
  Matrix R(s.c(), 0);
  if (s.is_massless() || !s.characteristic.statics.empty()) R = residual_vectors(s, stiffness);
  const Index k = V.cols(), n = k + R.cols();
  reduced.T.resize(s.c(), n);
  reduced.T << V, R;
  reduced.K = Matrix::Zero(n, n);
  reduced.K.diagonal() << s.eigenvalues, Vector::Constant(n - k, stiffness);
  reduced.M = Matrix::Zero(n, n);
  reduced.M.diagonal().head(k).setOnes();
}

}  // namespace

ReducedMatrices reduced_matrices(const Superelement& s, Index first_modal_node) {
  ReducedMatrices reduced;
  const Index c = s.c();
  for (Index i = 0; i < c; ++i) {
    const Index node = s.dof_node[i];
    reduced.interface.push_back(
        {s.node_ids[node], s.dof_component[i] + 1, s.coordinates.row(node).transpose(), 0});
  }
  if (s.has_interface_matrices()) {
    const Index k = s.k();
    reduced.K = Matrix::Zero(c + k, c + k);
    reduced.M = Matrix::Identity(c + k, c + k);
    reduced.K.topLeftCorner(c, c) = s.K_cc;
    reduced.K.diagonal().tail(k) = s.eigenvalues;
    reduced.M.topLeftCorner(c, c) = s.M_cc;
    reduced.M.bottomLeftCorner(k, c) = s.M_kc;
    reduced.M.topRightCorner(c, k) = s.M_kc.transpose();
    reduced.rows = std::move(reduced.interface);
    reduced.interface.clear();
  } else {
    add_modal(s, reduced);
  }
  const Index k = reduced.K.rows() - static_cast<Index>(reduced.rows.size());
  const Index last =
      s.node_ids.empty() ? 0 : *std::max_element(s.node_ids.begin(), s.node_ids.end());
  if (first_modal_node == 0) first_modal_node = last + 1;
  if (first_modal_node <= last)
    throw InputError("--first-modal-node " + std::to_string(first_modal_node) +
                     " found, expected above " + std::to_string(last) +
                     ", the interface's largest node");
  for (Index j = 0; j < k; ++j) {
    reduced.rows.push_back(
        {first_modal_node + j, 0, Vector3::Zero(), reduced.K.diagonal().tail(k)(j)});
  }
  return reduced;
}

}  // namespace cbr
