// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/node_response.hpp"

#include <vector>

#include "common/program.hpp"
#include "dynamics/contact/dense_panels.hpp"

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
  const Index n = block->rows();
  Matrix local(n, 1), moved = Matrix::Zero(n, 1);
  std::vector<Index> columns;
  for (Index i = 0; i < p.rows(); ++i) {
    local.col(0).segment<3>(3 * i) = axes.transpose() * p.row(i).transpose();
    for (int c = 0; c < 3 && !p.row(i).isZero(0); ++c) columns.push_back(3 * i + c);
  }
  add_columns(*block, columns, local, moved, n_threads());
  for (Index i = 0; i < x.rows(); ++i) x.row(i) += (axes * moved.col(0).segment<3>(3 * i)).transpose();
}

}  // namespace cbr
