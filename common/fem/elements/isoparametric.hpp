// SPDX-License-Identifier: GPL-3.0-or-later
// Element integrals for a fixed number of nodes n, so that the compiler sees every size. For the
// .cpp of this folder.
#pragma once

#include <Eigen/LU>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include "common/fem/elements/element.hpp"
#include "common/fem/elements/reference_element.hpp"

namespace cbr::isoparametric {

template <int n>
using Nodes = Eigen::Matrix<double, n, 3, Eigen::RowMajor>;
template <int n>
using DofMatrix = Eigen::Matrix<double, 3 * n, 3 * n>;

// Calls f with the element's number of nodes as a constant.
template <class F>
auto with_node_count(ElementType type, F f) {
  switch (n_nodes(type)) {
    case 4:
      return f(std::integral_constant<int, 4>());
    case 5:
      return f(std::integral_constant<int, 5>());
    case 6:
      return f(std::integral_constant<int, 6>());
    case 8:
      return f(std::integral_constant<int, 8>());
    case 10:
      return f(std::integral_constant<int, 10>());
    case 15:
      return f(std::integral_constant<int, 15>());
    case 20:
      return f(std::integral_constant<int, 20>());
    default:
      assert(n_nodes(type) == 27);
      return f(std::integral_constant<int, 27>());
  }
}

// Column q: sqrt(weight det J) dN_i/dx_a at point q, row 3 i + a.
template <int n>
using Gradients = Eigen::Matrix<double, 3 * n, Eigen::Dynamic, Eigen::ColMajor, 3 * n, 27>;

// C_acbd, component axes: stress_ac = C_acbd strain_bd.
class Elasticity {
 public:
  explicit Elasticity(const Material& material);

  // k_ab = C_acbd s_cd, s a 3 x 3 matrix of gradients' products
  Matrix3 stiffness(const Matrix3& s) const {
    Matrix3 k;
    if (is_isotropic_) {
      k = lambda_ * s + mu_ * s.transpose();
      k.diagonal().array() += mu_ * s.trace();
      return k;
    }
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) k(a, b) = C_[3 * a + b].cwiseProduct(s).sum();
    return k;
  }
  Matrix3 stress(const Matrix3& strain) const;

 private:
  bool is_isotropic_ = true;
  double lambda_ = 0, mu_ = 0;
  std::array<Matrix3, 9> C_;  // of a and b: c x d
};

// At the points of a table with the shape functions N (n x n_q), of an element at X: one for all
// where the material's axes are the same at all.
std::vector<Elasticity> elasticities(const Material& material, const Points& X, const Matrix& N);

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
    const Points& dN = table.dN[q];
    const Matrix3 J = jacobian<n>(X, dN);
    const double volume = table.weight[q] * J.determinant();
    assert(volume > 0);
    Eigen::Map<Nodes<n>>(A.col(q).data()) = std::sqrt(volume) * gradient<n>(dN, J);
  }
  return A;
}

// From S = A A^T (3 n x 3 n), S_(ia)(jb) = integral of dN_i/dx_a dN_j/dx_b:
//   K_(ia)(jb) = C_acbd S_(ic)(jd), of an isotropic material lambda S_(ia)(jb) + mu S_(ib)(ja) + mu
//   delta_ab sum_c S_(ic)(jc)
// Each entry and its mirror come from the same operations: K == K^T to the last bit.
template <int n>
DofMatrix<n> elastic_stiffness(const Gradients<n>& A, const Elasticity& material) {
  DofMatrix<n> S = DofMatrix<n>::Zero();
  for (Index q = 0; q < A.cols(); ++q)
    for (int j = 0; j < 3 * n; ++j) S.col(j).tail(3 * n - j) += A(j, q) * A.col(q).tail(3 * n - j);
  for (int j = 0; j < 3 * n; ++j)
    S.row(j).tail(3 * n - j - 1) = S.col(j).tail(3 * n - j - 1).transpose();
  DofMatrix<n> K;
  for (int j = 0; j < n; ++j)
    for (int i = j; i < n; ++i) {
      const Matrix3 s = S.template block<3, 3>(3 * i, 3 * j);
      Matrix3 k = material.stiffness(s);
      if (i == j) k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
      K.template block<3, 3>(3 * i, 3 * j) = k;
      K.template block<3, 3>(3 * j, 3 * i) = k.transpose();
    }
  return K;
}

// Of a material with other axes at each point.
template <int n>
DofMatrix<n> elastic_stiffness(const Gradients<n>& A, const std::vector<Elasticity>& of) {
  if (of.size() == 1) return elastic_stiffness<n>(A, of.front());
  DofMatrix<n> K = DofMatrix<n>::Zero();
  for (std::size_t q = 0; q < of.size(); ++q)
    K += elastic_stiffness<n>(Gradients<n>(A.col(static_cast<Index>(q))), of[q]);
  return K;
}

}  // namespace cbr::isoparametric
