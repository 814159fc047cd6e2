// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/scaled/scaled_modes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/linalg/dense_factor.hpp"
#include "common/linalg/huge_pages.hpp"

namespace cbr {

std::shared_ptr<const Matrix> ScaledRows::response(double h, double contact_step,
                                                   const ScaledGain& gain) const {
  if (last_.block && last_.h == h && last_.contact_step == contact_step) return last_.block;
  if (other_.block && other_.h == h && other_.contact_step == contact_step) {
    std::swap(last_, other_);
    return last_.block;
  }
  Vector weight(omega.size());  // sin(omega h) / omega, positive below omega h = pi
  for (Index j = 0; j < omega.size(); ++j)
    weight[j] = omega[j] == 0 ? h : std::sin(omega[j] * h) / omega[j];
  if (contact_step > 0) weight.array() *= gain.kept.array();
  Matrix B = zeros_on_huge_pages(Vt.cols(), Vt.cols());
  if (weight.size() == 0 || Vt.cols() == 0) {  // BLAS minds a product over nothing
  } else if (weight.minCoeff() >= 0) {
    const Matrix half = weight.cwiseSqrt().asDiagonal() * Vt;
    B.selfadjointView<Eigen::Lower>().rankUpdate(half.transpose());
  } else {
    B.triangularView<Eigen::Lower>() = Vt.transpose() * (weight.asDiagonal() * Vt);
  }
  const double scale = gain.scaled * std::sin(clip * h) / clip;
  for (Index j = 0; S && j < B.cols(); ++j)
    B.col(j).tail(B.rows() - j) += scale * S->col(j).tail(B.rows() - j);
  mirror_lower(B);
  other_ = std::move(last_);
  last_ = {h, contact_step, std::make_shared<const Matrix>(std::move(B))};
  return last_.block;
}

double ScaledModes::largest_frequency() const {
  const double kept = omega.size() > 0 ? omega.maxCoeff() : 0;
  return part ? std::max(clip, kept) : kept;
}

std::shared_ptr<const ScaledRows> ScaledModes::node_rows(const std::vector<Index>& nodes) const {
  auto& entry = node_rows_[nodes];
  if (entry) return entry;
  const Index m = static_cast<Index>(nodes.size());
  std::vector<Index> coordinates;
  for (const Index node : nodes)
    for (int c = 0; c < 3; ++c) coordinates.push_back(rows(node, c));
  auto set = std::make_shared<ScaledRows>();
  set->omega = omega;
  set->clip = clip;
  set->Vt = Matrix::Zero(omega.size(), 3 * m);
  for (Index i = 0; i < 3 * m; ++i)
    if (coordinates[i] >= 0) set->Vt.col(i) = V.row(coordinates[i]).transpose();
  if (part) set->S = std::make_shared<const Matrix>(part->block(coordinates));
  entry = std::move(set);
  return entry;
}

}  // namespace cbr
