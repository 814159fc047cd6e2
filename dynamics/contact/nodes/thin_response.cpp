// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/nodes/thin_response.hpp"

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/kernels/symmetric_product.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {

std::shared_ptr<const StaticRows> no_static_rows(std::size_t n_nodes) {
  auto rows = std::make_shared<StaticRows>();
  rows->first.assign(n_nodes + 1, 0);
  rows->direction.resize(0, 3);
  return rows;
}

void StaticRows::gather(const Matrix& f, Matrix& rows) const {
  rows.resize(size(), f.cols());
  for (Index q = 0; q < f.cols(); ++q)
    for (Index i = 0; i < size(); ++i)
      rows(i, q) = direction.row(i).dot(f.col(q).segment<3>(3 * node[i]).transpose());
}

void StaticRows::add_spread(const Matrix& w, Matrix& u) const {
  for (Index q = 0; q < w.cols(); ++q)
    for (Index i = 0; i < size(); ++i)
      u.col(q).segment<3>(3 * node[i]) += w(i, q) * direction.row(i).transpose();
}

// Both branches give the same bits: products with zeros are zeros.
Matrix ThinResponse::weighed(const Matrix& x) const {
  if (C_is_diagonal) return C.diagonal().asDiagonal() * x;
  return C * x;
}

// If most rows are loaded, reads half of the symmetric F, else the columns of loaded rows.
double press(const StaticRows& rows, const Matrix& pressed, Matrix& still,
             std::vector<Index>& columns) {
  still.setZero(pressed.rows(), pressed.cols());
  columns.clear();
  for (Index i = 0; i < pressed.rows(); ++i)
    if (!pressed.row(i).isZero(0)) columns.push_back(i);
  const Matrix* F = rows.F.dense();
  if (F == nullptr) {
    if (!columns.empty()) still = rows.F * pressed;
    return 0;
  }
  const auto s = static_cast<double>(pressed.rows()), loaded = static_cast<double>(columns.size());
  if (2 * loaded > s) {
    add_symmetric_product(*F, pressed, still, n_threads());
    return 4 * s * (s + 1);
  }
  add_columns(*F, columns, pressed, still, n_threads());
  return 8 * s * loaded;
}

double respond(const ThinResponse& S, const Matrix& p, Matrix& move, Matrix& still, ThinWork& work,
               bool still_is_known) {
  const Matrix& A = *S.A;
  move.setZero(p.rows(), p.cols());
  double bytes = 8 * static_cast<double>(A.size() * p.cols());
  std::vector<RowWeight> loaded;  // few nodes near contact have an impulse
  if (A.rows() > 0) {
    const LargeBlasWork blas = LargeBlasWork::reading(A.size());
    for (Index q = 0; q < p.cols(); ++q) {
      loaded.clear();
      for (Index i = 0; i < p.rows(); ++i)
        if (p(i, q) != 0) loaded.push_back({i, p(i, q)});
      work.kick.setZero(A.rows());
      add_weighted(A, loaded, 0, A.rows(), work.kick.data());
      bytes += 8 * static_cast<double>(A.rows() * std::ssize(loaded));
      if (S.C_is_diagonal) {
        work.kick.array() *= S.C.diagonal().array();
      } else {
        work.kick = S.C * work.kick;
      }
      move.col(q).noalias() = A.transpose() * work.kick;
    }
  }
  if (!still_is_known) {
    S.rows->gather(p, work.pressed);
    work.pressed /= S.h;
    bytes += press(*S.rows, work.pressed, still, work.columns);
  }
  S.rows->add_spread(still, move);
  return bytes;
}

}  // namespace cbr
