// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/nodes/static_compliance.hpp"

#include <algorithm>
#include <utility>

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
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
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

}  // namespace cbr
