// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/node_response.hpp"

namespace cbr {

Matrix NodeResponse::dense() const {
  if (!block) return diagonal.asDiagonal();
  const Index n = block->rows();
  Matrix S(n, n);
  for (Index j = 0; j < n; j += 3)
    for (Index i = 0; i < n; i += 3) S.block<3, 3>(i, j) = axes * block->block<3, 3>(i, j) * axes.transpose();
  return S;
}

void NodeResponse::add_product(const Points& p, Points& x) const {
  if (!block) {
    Eigen::Map<Vector>(x.data(), x.size()) += diagonal.cwiseProduct(Eigen::Map<const Vector>(p.data(), p.size()));
    return;
  }
  Points moved = Points::Zero(p.rows(), 3);
  Eigen::Map<Vector> y(moved.data(), moved.size());
  for (Index i = 0; i < p.rows(); ++i) {
    if (p.row(i).isZero(0)) continue;
    const Vector3 local = axes.transpose() * p.row(i).transpose();
    y.noalias() += block->middleCols<3>(3 * i) * local;
  }
  x += moved * axes.transpose();
}

}  // namespace cbr
