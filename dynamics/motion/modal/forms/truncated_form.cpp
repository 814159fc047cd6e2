// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/truncated_form.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/linalg/dense_factor.hpp"

namespace cbr {
namespace {

constexpr double share_of_fixed_modes = 2.5;
constexpr std::size_t least_nodes = 100;

Index modes_up_to(double highest, const ModalForm& all) {
  return std::upper_bound(all.omega.begin(), all.omega.end(), highest) - all.omega.begin();
}

// diag(1 / omega_h) V_h^T B, of the modes from `first` on   (h x s)
Matrix along_forces(const ModalForm& all, Index first, const StaticShare& forces,
                    const IndexTable& row) {
  const Index h = all.omega.size() - first;
  Matrix G = Matrix::Zero(h, forces.size());
  for (Index i = 0; i < forces.size(); ++i)
    for (int d = 0; d < 3; ++d)
      if (const Index r = row(forces.node[i], d); r >= 0 && forces.direction(i, d) != 0)
        G.col(i) += forces.direction(i, d) * all.V.row(r).tail(h).transpose();
  return all.omega.tail(h).cwiseInverse().asDiagonal() * G;
}

}  // namespace

std::optional<double> automatic_limit(const Vector& eigenvalues, const ModalForm& all) {
  if (eigenvalues.size() == 0) return std::nullopt;
  const double limit = share_of_fixed_modes * std::sqrt(std::max(0.0, eigenvalues.maxCoeff()));
  const Index n = modes_up_to(limit, all), h = all.omega.size() - n;
  const bool pays = n > all.n_rigid && 2 * h >= n && all.E.bottomRows(h).isZero(0);
  return pays ? std::optional(all.omega[n - 1]) : std::nullopt;
}

bool is_large_face(const StaticShare& forces) {
  return std::set<Index>(forces.node.begin(), forces.node.end()).size() >= least_nodes;
}

std::shared_ptr<const ModalForm> truncated_form(double highest,
                                                std::shared_ptr<const ModalForm> all,
                                                const StaticShare& forces, const Superelement& s) {
  const Index n = modes_up_to(highest, *all), h = all->omega.size() - n;
  auto form = std::make_shared<ModalForm>();
  form->omega = all->omega.head(n);
  form->V = all->V.leftCols(n);
  form->E = all->E.topRows(n);
  form->n_rigid = all->n_rigid;
  auto residual = std::make_shared<ResidualCompliance>();
  residual->quasi_static = along_forces(*all, n, forces, displacement_rows(s));
  Matrix F = Matrix::Zero(forces.size(), forces.size());
  F.selfadjointView<Eigen::Lower>().rankUpdate(residual->quasi_static.transpose());
  mirror_lower(F);
  residual->rows = static_rows(forces.node, forces.direction,
                               std::make_shared<const Matrix>(std::move(F)), s.coordinates.rows());
  residual->quasi_static.array().colwise() /= all->omega.tail(h).array();
  residual->omega_limit = highest;
  residual->whole = std::move(all);
  form->residual = std::move(residual);
  return form;
}

}  // namespace cbr
