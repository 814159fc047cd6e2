// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/hex8.hpp"

#include <Eigen/Cholesky>
#include <array>

namespace cbr {
namespace {

using isoparametric::DofMatrix;
using isoparametric::Elasticity;
using isoparametric::Gradients;

// Columns as of gradients<8>, below them those of the three incompatible functions 1 - xi_k^2, rows
// 3 (8 + k) + a.
Gradients<11> enhanced_gradients(const Hex8Nodes& X) {
  const ReferenceElement& reference = reference_element(ElementType::hex8);
  const QuadratureRule rule = gauss_hex(2);
  const Matrix3 J_0 = isoparametric::jacobian<8>(X, reference.center.dN[0]);
  const double det_0 = J_0.determinant();
  const Matrix3 J_0_inverse = J_0.inverse();
  Gradients<11> A(33, 8);
  for (Index q = 0; q < 8; ++q) {
    const auto p = static_cast<std::size_t>(q);
    const Points& dN = reference.stiffness.dN[p];
    const Matrix3 J = isoparametric::jacobian<8>(X, dN);
    const double det = J.determinant();
    assert(det > 0);
    const double root = std::sqrt(rule[p].weight * det);
    Eigen::Map<Hex8Nodes>(A.col(q).data()) = root * isoparametric::gradient<8>(dN, J);
    // d(1 - xi_k^2)/dx = (det J_0 / det J) (-2 xi_k) (column k of J_0^-1)
    for (int k = 0; k < 3; ++k)
      A.col(q).segment<3>(24 + 3 * k) =
          root * (det_0 / det) * (-2 * rule[p].xi(k)) * J_0_inverse.col(k);
  }
  return A;
}

}  // namespace

Hex8Matrix hex8_incompatible_stiffness(const Hex8Nodes& X,
                                       const std::vector<isoparametric::Elasticity>& material) {
  const DofMatrix<11> K = isoparametric::elastic_stiffness<11>(enhanced_gradients(X), material);
  // Y = L^-1 K_au, K_aa = L L^T   (9 x 24)
  const Eigen::LLT<Eigen::Matrix<double, 9, 9>> llt(K.bottomRightCorner<9, 9>());
  Eigen::Matrix<double, 9, 24> Y = K.bottomLeftCorner<9, 24>();
  llt.matrixL().solveInPlace(Y);
  Hex8Matrix condensed = K.topLeftCorner<24, 24>();
  for (int j = 0; j < 24; ++j)
    for (int i = j; i < 24; ++i) {
      condensed(i, j) -= Y.col(i).dot(Y.col(j));
      condensed(j, i) = condensed(i, j);
    }
  return condensed;
}

std::array<Matrix3, 8> hex8_incompatible_gradients(
    const Hex8Nodes& X, const std::vector<isoparametric::Elasticity>& material,
    const Hex8Nodes& u) {
  const Gradients<11> A = enhanced_gradients(X);
  const DofMatrix<11> K = isoparametric::elastic_stiffness<11>(A, material);
  const Eigen::Map<const Eigen::Matrix<double, 24, 1>> u_e(u.data());
  const Eigen::LLT<Eigen::Matrix<double, 9, 9>> llt(K.bottomRightCorner<9, 9>());
  Eigen::Matrix<double, 33, 1> all;
  all << u_e, -llt.solve(K.bottomLeftCorner<9, 24>() * u_e);
  const Eigen::Map<const isoparametric::Nodes<11>> motion(all.data());
  const ShapeTable& table = reference_element(ElementType::hex8).stiffness;
  std::array<Matrix3, 8> H;
  for (std::size_t q = 0; q < 8; ++q) {
    const double volume =
        table.weight[q] * isoparametric::jacobian<8>(X, table.dN[q]).determinant();
    const Eigen::Map<const isoparametric::Nodes<11>> slopes(A.col(static_cast<Index>(q)).data());
    H[q] = motion.transpose().lazyProduct(slopes) / std::sqrt(volume);
  }
  return H;
}

MeanGradient hex8_mean_gradient(const Hex8Nodes& X) {
  // 2 x 2 x 2 points integrate both exactly: det J and det J J^-T dN are of degree 2 in each
  // coordinate.
  const ShapeTable& table = reference_element(ElementType::hex8).stiffness;
  MeanGradient mean{Hex8Nodes::Zero(), 0};
  for (Index q = 0; q < table.size(); ++q) {
    const auto p = static_cast<std::size_t>(q);
    const Matrix3 J = isoparametric::jacobian<8>(X, table.dN[p]);
    const double volume = table.weight[p] * J.determinant();
    mean.b += volume * isoparametric::gradient<8>(table.dN[p], J);
    mean.volume += volume;
  }
  mean.b /= mean.volume;
  return mean;
}

Hex8Matrix hex8_hourglass_stiffness(const Hex8Nodes& X, const Material& material, double kappa) {
  const auto [b, volume] = hex8_mean_gradient(X);
  Gradients<8> A(24, 1);
  Eigen::Map<Hex8Nodes>(A.data()) = std::sqrt(volume) * b;
  Hex8Matrix K = isoparametric::elastic_stiffness<8>(A, Elasticity(material));

  // The four products of two or three of the nodes' reference coordinates: eta zeta, zeta xi, xi
  // eta, xi eta zeta.
  Eigen::Matrix<double, 8, 4> h;
  h << 1, 1, 1, -1, 1, -1, -1, 1, -1, -1, 1, -1, -1, 1, -1, 1, -1, -1, 1, 1, -1, 1, -1, -1, 1, 1, 1,
      1, 1, -1, -1, -1;
  // gamma = (h - b X^T h) / sqrt 8   (8 x 4)
  const Eigen::Matrix<double, 3, 4> slopes = X.transpose().lazyProduct(h);
  const Eigen::Matrix<double, 8, 4> gamma = (h - b.lazyProduct(slopes)) / std::sqrt(8.0);
  const double youngs_modulus =
      material.orthotropy ? material.orthotropy->youngs_moduli.maxCoeff() : material.youngs_modulus;
  const double scale = kappa * youngs_modulus * volume * b.squaredNorm();
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i)
      K.block<3, 3>(3 * i, 3 * j).diagonal().array() += scale * gamma.row(i).dot(gamma.row(j));
  return K;
}

}  // namespace cbr
