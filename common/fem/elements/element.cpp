// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/element.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "common/base/error.hpp"
#include "common/fem/elements/hex8.hpp"
#include "common/fem/elements/isoparametric.hpp"

namespace cbr {
namespace {

using isoparametric::Nodes;
using isoparametric::with_node_count;

constexpr std::array<std::string_view, 3> formulation_names = {"hex8", "hex8-incompatible",
                                                               "hex8-hourglass"};

// weight det J at each point of a table; the weights of corner tables are zero and count as one.
template <int n>
Vector determinants(const Nodes<n>& X, const ShapeTable& table) {
  Vector det(table.size());
  for (Index q = 0; q < table.size(); ++q) {
    const auto p = static_cast<std::size_t>(q);
    det(q) = isoparametric::jacobian<n>(X, table.dN[p]).determinant();
  }
  return det;
}

// weight det J at the points of the mass's rule
Vector mass_volumes(ElementType type, const Points& X) {
  const ShapeTable& table = reference_element(type).mass;
  const Eigen::Map<const Vector> weight(table.weight.data(), table.size());
  return with_node_count(type, [&](auto n) -> Vector {
    return weight.cwiseProduct(determinants<n()>(isoparametric::local_coordinates<n()>(X), table));
  });
}

bool is_quadratic(ElementType type) { return n_nodes(type) > n_corners(type); }

}  // namespace

Hex8Formulation parse_hex8_formulation(std::string_view text) {
  for (std::size_t i = 0; i < formulation_names.size(); ++i)
    if (formulation_names[i] == text) return static_cast<Hex8Formulation>(i);
  const std::vector<std::string> allowed(formulation_names.begin(), formulation_names.end());
  throw InputError("element: '" + std::string(text) +
                   "' is not a formulation of 8-node hexes: use one of " + join(allowed) +
                   nearest_name(std::string(text), allowed));
}

std::string_view name(Hex8Formulation formulation) {
  return formulation_names[static_cast<std::size_t>(formulation)];
}

Matrix element_stiffness(ElementType type, Hex8Formulation hex8, const Points& X,
                         const Material& material) {
  if (type == ElementType::hex8 && hex8 != Hex8Formulation::full) {
    const auto local = isoparametric::local_coordinates<8>(X);
    return hex8 == Hex8Formulation::incompatible ? hex8_incompatible_stiffness(local, material)
                                                 : hex8_hourglass_stiffness(local, material);
  }
  return with_node_count(type, [&](auto n) -> Matrix {
    const auto local = isoparametric::local_coordinates<n()>(X);
    const auto A = isoparametric::gradients<n()>(local, reference_element(type).stiffness);
    return isoparametric::elastic_stiffness<n()>(A, isoparametric::Elasticity(material));
  });
}

Matrix element_mass(ElementType type, const Points& X, double density) {
  const Matrix& N = reference_element(type).mass.N;
  const Vector volume = mass_volumes(type, X);
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
  const Vector volume = mass_volumes(type, X);
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

Eigen::Matrix<double, 6, 1> element_stress(ElementType type, Hex8Formulation hex8, const Points& X,
                                           const Material& material, const Points& u) {
  // The incompatible modes have no gradient at the centre: only the hourglass formulation differs.
  const Matrix3 H = with_node_count(type, [&](auto n) -> Matrix3 {
    const auto local = isoparametric::local_coordinates<n()>(X);
    const Points& dN = reference_element(type).center.dN[0];
    Nodes<n()> g = isoparametric::gradient<n()>(dN, isoparametric::jacobian<n()>(local, dN));
    if constexpr (n() == 8) {
      if (hex8 == Hex8Formulation::hourglass) g = hex8_mean_gradient(local).b;
    }
    // H_ab = du_a/dx_b
    return isoparametric::local_coordinates<n()>(u).transpose().lazyProduct(g);
  });
  const Matrix3 stress = isoparametric::Elasticity(material).stress(0.5 * (H + H.transpose()));
  return {stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(1, 2), stress(2, 0)};
}

}  // namespace cbr
