// SPDX-License-Identifier: GPL-3.0-or-later
// Stress from strain: isotropic by Lame's constants, orthotropic by a tensor in the component's
// axes.
#include <array>

#include "common/fem/elements/isoparametric.hpp"

namespace cbr {

Matrix3 normal_stiffness(const Orthotropy& of) {
  Matrix3 compliance = of.youngs_moduli.cwiseInverse().asDiagonal();
  compliance(0, 1) = compliance(1, 0) = -of.poissons_ratios[0] / of.youngs_moduli[0];
  compliance(1, 2) = compliance(2, 1) = -of.poissons_ratios[1] / of.youngs_moduli[1];
  compliance(0, 2) = compliance(2, 0) = -of.poissons_ratios[2] / of.youngs_moduli[0];
  return compliance.inverse();
}

bool is_definite(const Orthotropy& of) {
  const Matrix3 normal = normal_stiffness(of);
  return of.youngs_moduli.minCoeff() > 0 && of.shear_moduli.minCoeff() > 0 && normal(0, 0) > 0 &&
         normal.topLeftCorner<2, 2>().determinant() > 0 && normal.determinant() > 0;
}

Material material_at(const Material& material, const Vector3& x) {
  if (!material.orthotropy || !material.orthotropy->center) return material;
  Material own = material;
  Orthotropy& of = *own.orthotropy;
  const Vector3 axial = of.axes.row(2), arm = axial.cross(x - *of.center).cross(axial);
  const Vector3 radial = arm.isZero(0) ? Vector3(of.axes.row(0)) : arm.normalized();
  of.axes << radial.transpose(), axial.cross(radial).transpose(), axial.transpose();
  of.center.reset();
  return own;
}

namespace isoparametric {
namespace {

using Tensor = std::array<double, 81>;  // entry 27 i + 9 j + 3 k + l

Tensor in_own_axes(const Orthotropy& of) {
  Tensor C{};
  const auto at = [&](int i, int j, int k, int l) -> double& {
    return C[27 * i + 9 * j + 3 * k + l];
  };
  const Matrix3 normal = normal_stiffness(of);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) at(i, i, j, j) = 0.5 * (normal(i, j) + normal(j, i));
  constexpr std::array<std::array<int, 2>, 3> planes = {{{0, 1}, {1, 2}, {0, 2}}};
  for (int p = 0; p < 3; ++p) {
    const auto [i, j] = planes[p];
    at(i, j, i, j) = at(i, j, j, i) = at(j, i, i, j) = at(j, i, j, i) = of.shear_moduli[p];
  }
  return C;
}

// C_ijkl = Q_pi Q_qj Q_rk Q_sl C_pqrs, Q the rows of the material's axes: four times over the first
// index, which becomes the last.
Tensor in_component_axes(const Orthotropy& of) {
  Tensor C = in_own_axes(of);
  for (int turn = 0; turn < 4; ++turn) {
    Tensor next{};
    for (int rest = 0; rest < 27; ++rest)
      for (int i = 0; i < 3; ++i)
        for (int p = 0; p < 3; ++p) next[3 * rest + i] += of.axes(p, i) * C[27 * p + rest];
    C = next;
  }
  return C;
}

}  // namespace

Elasticity::Elasticity(const Material& m) : is_isotropic_(!m.orthotropy) {
  if (is_isotropic_) {
    lambda_ =
        m.youngs_modulus * m.poissons_ratio / ((1 + m.poissons_ratio) * (1 - 2 * m.poissons_ratio));
    mu_ = m.youngs_modulus / (2 * (1 + m.poissons_ratio));
    return;
  }
  const Tensor C = in_component_axes(*m.orthotropy);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (int c = 0; c < 3; ++c)
        for (int d = 0; d < 3; ++d) C_[3 * a + b](c, d) = C[27 * a + 9 * c + 3 * b + d];
}

std::vector<Elasticity> elasticities(const Material& m, const Points& X, const Matrix& N) {
  if (!m.orthotropy || !m.orthotropy->center) return {Elasticity(m)};
  std::vector<Elasticity> all;
  for (Index q = 0; q < N.cols(); ++q) all.emplace_back(material_at(m, X.transpose() * N.col(q)));
  return all;
}

Matrix3 Elasticity::stress(const Matrix3& strain) const {
  if (is_isotropic_) return lambda_ * strain.trace() * Matrix3::Identity() + 2 * mu_ * strain;
  Matrix3 stress = Matrix3::Zero();
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (int c = 0; c < 3; ++c)
        for (int d = 0; d < 3; ++d) stress(a, c) += C_[3 * a + b](c, d) * strain(b, d);
  return 0.5 * (stress + stress.transpose());
}

}  // namespace isoparametric
}  // namespace cbr
