// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/nodes/node_response.hpp"

#include <vector>

#include "common/linalg/blas_threads.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {
namespace {

// Rotates the vectors of all nodes   (3 m)
Matrix in_axes(const Points& p, const Matrix3& axes) {
  Matrix local(p.size(), 1);
  for (Index i = 0; i < p.rows(); ++i)
    local.col(0).segment<3>(3 * i) = axes.transpose() * p.row(i).transpose();
  return local;
}

// A^T C A + B F B^T / h
Matrix formed(const ThinResponse& S) {
  const Index s = S.rows->size();
  Matrix B = Matrix::Zero(S.n_dofs(), s);
  S.rows->add_spread(Matrix::Identity(s, s), B);
  return S.A->transpose() * S.C * *S.A + B * S.rows->F.formed() * B.transpose() / S.h;
}

}  // namespace

Matrix NodeResponse::dense() const {
  if (is_diagonal()) return diagonal.asDiagonal();
  const Index n = n_dofs();
  const Matrix thick = block ? Matrix() : formed(*thin);
  const Matrix& of_axes = block ? *block : thick;
  Matrix S(n, n);
  for (Index j = 0; j < n; j += 3)
    for (Index i = 0; i < n; i += 3)
      S.block<3, 3>(i, j) = axes * of_axes.block<3, 3>(i, j) * axes.transpose();
  return S;
}

void NodeResponse::add_product(const Points& p, Points& x) const {
  if (is_diagonal()) {
    Eigen::Map<Vector>(x.data(), x.size()) +=
        diagonal.cwiseProduct(Eigen::Map<const Vector>(p.data(), p.size()));
    return;
  }
  const Matrix local = in_axes(p, axes);
  Matrix moved = Matrix::Zero(n_dofs(), 1);
  if (thin) {
    Matrix still;
    ThinWork work;
    respond(*thin, local, moved, still, work);
  } else {
    std::vector<Index> columns;
    for (Index i = 0; i < p.rows(); ++i)
      for (int c = 0; c < 3 && !p.row(i).isZero(0); ++c) columns.push_back(3 * i + c);
    add_columns(*block, columns, local, moved, n_threads());
  }
  for (Index i = 0; i < x.rows(); ++i)
    x.row(i) += (axes * moved.col(0).segment<3>(3 * i)).transpose();
}

}  // namespace cbr
