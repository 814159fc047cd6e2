// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/condensation/superelement_algebra.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {

Matrix rigid_motions_of_parts(const Superelement& s, const std::vector<Index>& part) {
  if (s.fixed.any()) return reduced_rigid_modes(s, s.rigid_body.center) * free_combinations(s);
  const Index n_parts = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
  std::vector<Vector> columns;
  for (Index number = 0; number < n_parts; ++number) {
    Vector3 center = Vector3::Zero();
    double count = 0, size = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (part[i] == number) {
        center += Vector3(s.coordinates.row(static_cast<Index>(i)));
        count += 1;
      }
    }
    if (count == 0) continue;
    center /= count;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (part[i] == number)
        size = std::max(size, (Vector3(s.coordinates.row(static_cast<Index>(i))) - center).norm());
    }
    // Rotations about the part's centre, scaled by its size, so that all six are of the same
    // magnitude.
    const Points x = (s.coordinates.rowwise() - center.transpose()) / (size > 0 ? size : 1.0);
    const Matrix all = rigid_modes(x, Vector3::Zero());
    Matrix R = Matrix::Zero(s.n(), 6);
    for (Index i = 0; i < s.c(); ++i) {
      const auto node = static_cast<std::size_t>(s.dof_node[i]);
      if (part[node] != number) continue;
      const int component = s.dof_component[i];
      if (component < 3) {
        R.row(s.k() + i) = all.row(3 * static_cast<Index>(node) + component);
      } else {
        R(s.k() + i, component) = 1 / (size > 0 ? size : 1.0);
      }
    }
    // A part that is all interface may be as small as one node of a mechanism: only independent
    // motions count.
    const PivotedQr qr(R, 1e-10);
    for (Index j = 0; j < qr.rank(); ++j) columns.emplace_back(R.col(qr.column(j)));
  }
  Matrix R(s.n(), static_cast<Index>(columns.size()));
  for (Index j = 0; j < R.cols(); ++j) R.col(j) = columns[j];
  return R;
}

void orthonormalise(const std::function<Matrix(const Matrix&)>& times_M, Matrix& X,
                    const char* what) {
  if (X.cols() == 0) return;
  for (int pass = 0; pass < 2; ++pass) {
    const Cholesky cholesky(X.transpose() * times_M(X));
    if (!cholesky.ok())
      throw RunError("the mass of " + std::string(what) + " is not positive definite");
    cholesky.divide_by_upper(X);
  }
}

void orthonormalise(const Matrix& M, Matrix& X, const char* what) {
  orthonormalise([&](const Matrix& Y) { return Matrix(M * Y); }, X, what);
}

HeldStiffness hold_rigid_motions(const Matrix& K_cc, const Matrix& R) {
  if (R.cols() == 0) return {K_cc, R, 0};
  HeldStiffness held{K_cc, orthonormal_basis(R), K_cc.diagonal().mean()};
  held.K.noalias() += held.scale * held.N * held.N.transpose();
  return held;
}

Cholesky residual_mass_factor(const Superelement& s) {
  Matrix M_res = s.M_cc;
  if (s.k() > 0) M_res.noalias() -= s.M_kc.transpose() * s.M_kc;
  return Cholesky(std::move(M_res));
}

}  // namespace cbr
