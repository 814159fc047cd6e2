// SPDX-License-Identifier: GPL-3.0-or-later
// Element integrals for a fixed number of nodes n, so that the compiler sees every size. For the .cpp of this folder.
#pragma once

#include <Eigen/LU>
#include <cassert>
#include <cmath>

#include "common/elements/element.hpp"
#include "common/elements/reference_element.hpp"

namespace cbr::isoparametric {

template <int n>
using Nodes = Eigen::Matrix<double, n, 3, Eigen::RowMajor>;
template <int n>
using DofMatrix = Eigen::Matrix<double, 3 * n, 3 * n>;

// Column q: sqrt(weight det J) dN_i/dx_a at point q, row 3 i + a.
template <int n>
using Gradients = Eigen::Matrix<double, 3 * n, Eigen::Dynamic, Eigen::ColMajor, 3 * n, 27>;

struct Lame {
  double lambda, mu;
  explicit Lame(const Material& m)
      : lambda(m.youngs_modulus * m.poissons_ratio / ((1 + m.poissons_ratio) * (1 - 2 * m.poissons_ratio))),
        mu(m.youngs_modulus / (2 * (1 + m.poissons_ratio))) {}
};

// Coordinates from the first node: an element far from the origin loses no digits in its Jacobian.
template <int n>
Nodes<n> local_coordinates(const Points& X) {
  assert(X.rows() == n);
  const Eigen::Map<const Nodes<n>> all(X.data());
  return all.rowwise() - all.row(0);
}

// J(k, c) = dx_c / dxi_k
template <int n>
Matrix3 jacobian(const Nodes<n>& X, const Points& dN) {
  const Eigen::Map<const Nodes<n>> slopes(dN.data());
  return slopes.transpose().lazyProduct(X);
}

// dN/dx = dN/dxi J^-T   (n x 3)
template <int n>
Nodes<n> gradient(const Points& dN, const Matrix3& J) {
  const Eigen::Map<const Nodes<n>> slopes(dN.data());
  return slopes.lazyProduct(J.inverse().transpose());
}

template <int n>
Gradients<n> gradients(const Nodes<n>& X, const ShapeTable& table) {
  Gradients<n> A(3 * n, table.size());
  for (Index q = 0; q < table.size(); ++q) {
    const Points& dN = table.dN[static_cast<std::size_t>(q)];
    const Matrix3 J = jacobian<n>(X, dN);
    const double volume = table.weight[static_cast<std::size_t>(q)] * J.determinant();
    assert(volume > 0);
    Eigen::Map<Nodes<n>>(A.col(q).data()) = std::sqrt(volume) * gradient<n>(dN, J);
  }
  return A;
}

// Isotropic elasticity from S = A A^T (3 n x 3 n), S_(ia)(jb) = integral of dN_i/dx_a dN_j/dx_b:
//   K_(ia)(jb) = lambda S_(ia)(jb) + mu S_(ib)(ja) + mu delta_ab sum_c S_(ic)(jc)
// Each entry and its mirror come from the same operations: K == K^T to the last bit.
template <int n>
DofMatrix<n> elastic_stiffness(const Gradients<n>& A, const Lame& material) {
  DofMatrix<n> S = DofMatrix<n>::Zero();
  for (Index q = 0; q < A.cols(); ++q)
    for (int j = 0; j < 3 * n; ++j) S.col(j).tail(3 * n - j) += A(j, q) * A.col(q).tail(3 * n - j);
  for (int j = 0; j < 3 * n; ++j) S.row(j).tail(3 * n - j - 1) = S.col(j).tail(3 * n - j - 1).transpose();
  DofMatrix<n> K;
  for (int j = 0; j < n; ++j)
    for (int i = j; i < n; ++i) {
      const Matrix3 s = S.template block<3, 3>(3 * i, 3 * j);
      Matrix3 k = material.lambda * s + material.mu * s.transpose();
      k.diagonal().array() += material.mu * s.trace();
      K.template block<3, 3>(3 * i, 3 * j) = k;
      K.template block<3, 3>(3 * j, 3 * i) = k.transpose();
    }
  return K;
}

}  // namespace cbr::isoparametric
