// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/element.hpp"

#include <algorithm>
#include <limits>

#include "common/fem/elements/hex8.hpp"
#include "common/fem/elements/isoparametric.hpp"

namespace cbr {
namespace {

using isoparametric::elasticities;
using isoparametric::Nodes;
using isoparametric::with_node_count;

// weight det J at the points of a rule
Vector point_volumes(ElementType type, const Points& X, const ShapeTable& table) {
  return with_node_count(type, [&](auto n) -> Vector {
    const auto local = isoparametric::local_coordinates<n()>(X);
    Vector volume(table.size());
    for (Index q = 0; q < table.size(); ++q) {
      const auto p = static_cast<std::size_t>(q);
      volume(q) = table.weight[p] * isoparametric::jacobian<n()>(local, table.dN[p]).determinant();
    }
    return volume;
  });
}

// The rule of reduced integration if the element has it, else `full`.
const ShapeTable& integration_points(ElementType type, HexFormulation hex, const ShapeTable& full) {
  const ShapeTable& reduced = reference_element(type).reduced;
  return hex == HexFormulation::reduced && reduced.size() > 0 ? reduced : full;
}

bool is_quadratic(ElementType type) { return n_nodes(type) > n_corners(type); }

}  // namespace

Matrix element_stiffness(ElementType type, HexFormulation hex, const Points& X,
                         const Material& material) {
  if (type == ElementType::hex8 && hex != HexFormulation::full) {
    const auto local = isoparametric::local_coordinates<8>(X);
    if (hex == HexFormulation::incompatible)
      return hex8_incompatible_stiffness(
          local, elasticities(material, X, reference_element(type).stiffness.N));
    return hex8_hourglass_stiffness(local, material_at(material, X.colwise().mean()),
                                    hourglass_coefficient(hex));
  }
  const ShapeTable& table = integration_points(type, hex, reference_element(type).stiffness);
  return with_node_count(type, [&](auto n) -> Matrix {
    const auto local = isoparametric::local_coordinates<n()>(X);
    const auto A = isoparametric::gradients<n()>(local, table);
    return isoparametric::elastic_stiffness<n()>(A, elasticities(material, X, table.N));
  });
}

Matrix element_mass(ElementType type, const Points& X, double density, HexFormulation hex) {
  const ShapeTable& table = integration_points(type, hex, reference_element(type).mass);
  const Matrix& N = table.N;
  const Vector volume = point_volumes(type, X, table);
  // M_ij = rho sum_q w det J N_i N_j   (n x n), the lower triangle mirrored
  Matrix M(N.rows(), N.rows());
  for (Index j = 0; j < M.cols(); ++j)
    for (Index i = j; i < M.rows(); ++i) {
      double sum = 0;
      for (Index q = 0; q < N.cols(); ++q) sum += volume(q) * N(i, q) * N(j, q);
      M(i, j) = M(j, i) = density * sum;
    }
  return M;
}

Vector element_lumped_mass(ElementType type, const Points& X, double density) {
  const Matrix& N = reference_element(type).mass.N;
  const Vector volume = point_volumes(type, X, reference_element(type).mass);
  Vector m = Vector::Zero(N.rows());
  // Row sums are sum_q w det J N_i; those of quadratic elements may be negative, the diagonal sum_q
  // w det J N_i^2 cannot.
  for (Index q = 0; q < N.cols(); ++q) {
    if (is_quadratic(type))
      m += volume(q) * N.col(q).cwiseAbs2();
    else
      m += volume(q) * N.col(q);
  }
  return m * (density * volume.sum() / m.sum());
}

double element_quality(ElementType type, const Points& X) {
  // Below this share of the product of the three edge vectors' lengths a determinant is rounding
  // error, and below this share of the element's size an edge vector is.
  constexpr double degenerate = 1e-12;
  const ReferenceElement& reference = reference_element(type);
  return with_node_count(type, [&](auto n) -> double {
    const auto local = isoparametric::local_coordinates<n()>(X);
    // A scale of its own: no overflow, whatever the unit of length.
    const double size = local.cwiseAbs().maxCoeff();
    if (!(size > 0)) return 0;
    const Nodes<n()> scaled = local / size;
    double smallest = std::numeric_limits<double>::infinity(), volume = 0;
    for (const ShapeTable* table : {&reference.stiffness, &reference.corners})
      for (std::size_t q = 0; q < table->dN.size(); ++q) {
        const Matrix3 J = isoparametric::jacobian<n()>(scaled, table->dN[q]);
        const double det = J.determinant();
        const Vector3 edge = J.rowwise().norm();
        if (det >= 0 && (det <= degenerate * edge.prod() || edge.minCoeff() <= degenerate))
          return 0;
        smallest = std::min(smallest, det);
        volume += table->weight[q] * det;
      }
    if (volume <= 0) return -std::numeric_limits<double>::infinity();
    return smallest * reference.volume / volume;
  });
}

Eigen::Matrix<double, 6, 1> element_stress(ElementType type, HexFormulation hex, const Points& X,
                                           const Material& material, const Points& u) {
  // The incompatible modes have no gradient at the centre: only hexes of one point differ.
  const Matrix3 H = with_node_count(type, [&](auto n) -> Matrix3 {
    const auto local = isoparametric::local_coordinates<n()>(X);
    const Points& dN = reference_element(type).center.dN[0];
    Nodes<n()> g = isoparametric::gradient<n()>(dN, isoparametric::jacobian<n()>(local, dN));
    if constexpr (n() == 8) {
      if (has_one_point(hex)) g = hex8_mean_gradient(local).b;
    }
    // H_ab = du_a/dx_b
    return isoparametric::local_coordinates<n()>(u).transpose().lazyProduct(g);
  });
  const Matrix3 stress = elasticities(material, X, reference_element(type).center.N)
                             .front()
                             .stress(0.5 * (H + H.transpose()));
  return {stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(1, 2), stress(2, 0)};
}

}  // namespace cbr
