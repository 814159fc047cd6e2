// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/nodes/thin_response.hpp"

#include <algorithm>
#include <utility>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/kernels/symmetric_product.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {

StaticCompliance::StaticCompliance(const std::vector<ComplianceLevel>& levels) {
  for (const ComplianceLevel& level : levels)
    levels_.push_back({level.P, std::make_shared<const SparseMatrix>(level.S)});
}

Matrix StaticCompliance::formed() const {
  return dense_ ? *dense_ : *this * Matrix::Identity(size(), size());
}

StaticCompliance StaticCompliance::of_rows(const std::vector<Index>& rows) const {
  if (dense_) return {std::make_shared<const Matrix>((*dense_)(rows, rows))};
  StaticCompliance part = *this;
  for (Level& level : part.levels_) {
    std::vector<Eigen::Triplet<double, Index>> shares;
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (SparseMatrix::InnerIterator it(level.P, rows[i]); it; ++it)
        shares.emplace_back(it.row(), static_cast<Index>(i), it.value());
    level.P = SparseMatrix(level.P.rows(), static_cast<Index>(rows.size()));
    level.P.setFromTriplets(shares.begin(), shares.end());
  }
  return part;
}

Matrix StaticCompliance::operator*(const Matrix& X) const {
  if (dense_) return *dense_ * X;
  Matrix Y = Matrix::Zero(X.rows(), X.cols());
  for (const Level& level : levels_)
    Y.noalias() += level.P.transpose() * Matrix(*level.S * Matrix(level.P * X));
  return Y;
}

Vector StaticCompliance::Level::at_places(const std::vector<RowWeight>& x) const {
  Vector pushed = Vector::Zero(P.rows()), moved = Vector::Zero(P.rows());
  std::vector<Index> places;
  for (const RowWeight& of : x)
    for (SparseMatrix::InnerIterator it(P, of.row); it; ++it) {
      if (pushed[it.row()] == 0) places.push_back(it.row());
      pushed[it.row()] += of.weight * it.value();
    }
  sort_uniquely(places);
  for (const Index a : places)
    for (SparseMatrix::InnerIterator it(*S, a); it; ++it) moved[it.row()] += pushed[a] * it.value();
  return moved;
}

void StaticCompliance::add_products(const std::vector<std::vector<RowWeight>>& x,
                                    const std::vector<double*>& y) const {
  const Index s = size();
  if (dense_) {
    for (Index begin = 0; begin < s; begin += weighted_at_once)
      for (std::size_t k = 0; k < x.size(); ++k)
        add_weighted(*dense_, x[k], begin, std::min(begin + weighted_at_once, s), y[k] + begin);
    return;
  }
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (x[k].empty()) continue;
    for (const Level& level : levels_)
      Eigen::Map<Vector>(y[k], s).noalias() += level.P.transpose() * level.at_places(x[k]);
  }
}

void StaticCompliance::add_product_at(const std::vector<RowWeight>& x,
                                      const std::vector<Index>& rows, Vector& y) const {
  for (const Level& level : levels_) {
    const Vector moved = level.at_places(x);
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (SparseMatrix::InnerIterator it(level.P, rows[i]); it; ++it)
        y[static_cast<Index>(i)] += it.value() * moved[it.row()];
  }
}

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
