// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/nodal_stress.hpp"

#include <array>

#include "common/fem/elements/hex8.hpp"
#include "common/fem/elements/isoparametric.hpp"
#include "common/fem/elements/shell_plane.hpp"

namespace cbr {
namespace {

using isoparametric::Elasticity;
using isoparametric::Nodes;

// Points where stress is sampled, and their extrapolation to the nodes.
struct Sampling {
  Matrix N;                // n x points
  std::vector<Points> dN;  // at each of the points, n x 3
  Matrix at_nodes;         // points x n: column a are the weights of the points at node a
};

// Lagrange's polynomial of two points at +-1/sqrt 3, of the one at p
double of_line(double p, double x) { return 0.5 * (1 + 3 * p * x); }

// The linear function that is 1 at the point q of a rule of corner points and 0 at the others; d =
// 2: triangle, 3: tetrahedron. With barycentric coordinates L the points are (1 - d a, a, .., a)
// permuted.
double of_simplex(int d, const Vector3& q, const Vector3& x) {
  const auto barycentric = [d](const Vector3& xi) {
    Vector L(d + 1);
    L << 1 - xi.head(d).sum(), xi.head(d);
    return L;
  };
  const Vector of_point = barycentric(q);
  Index corner = 0;
  of_point.maxCoeff(&corner);
  const double a = of_point.minCoeff();
  return (barycentric(x)[corner] - a) / (1 - (d + 1) * a);
}

double weight(ElementType type, const Vector3& q, const Vector3& x) {
  switch (type) {
    case ElementType::tet4:
      return 1;
    case ElementType::tet10:
      return of_simplex(3, q, x);
    case ElementType::wedge6:
    case ElementType::wedge15:
      return of_simplex(2, q, x) * of_line(q.z(), x.z());
    case ElementType::pyramid5:
      return of_line(q.x(), x.x()) * of_line(q.y(), x.y());
    default:
      return of_line(q.x(), x.x()) * of_line(q.y(), x.y()) * of_line(q.z(), x.z());
  }
}

QuadratureRule points_of(ElementType type) {
  switch (type) {
    case ElementType::tet4:
      return tetrahedron_rule(1);
    case ElementType::tet10:
      return tetrahedron_rule(4);
    case ElementType::wedge6:
    case ElementType::wedge15:
      return wedge_rule(3, 2);
    case ElementType::pyramid5:
      return pyramid_rule(2, 1);
    default:
      return gauss_hex(2);
  }
}

Sampling sample(ElementType type) {
  if (dimension(type) != 3) return {};
  const QuadratureRule rule = points_of(type);
  Sampling sampling;
  sampling.at_nodes.resize(static_cast<Index>(rule.size()), n_nodes(type));
  sampling.N.resize(n_nodes(type), static_cast<Index>(rule.size()));
  for (const QuadraturePoint& point : rule) {
    const ShapeFunctions shape = shape_functions(type, point.xi);
    sampling.N.col(static_cast<Index>(sampling.dN.size())) = shape.N;
    sampling.dN.push_back(shape.dN);
  }
  for (Index a = 0; a < n_nodes(type); ++a) {
    const Vector3 x = place_of_node(type, a);
    for (std::size_t q = 0; q < rule.size(); ++q)
      sampling.at_nodes(static_cast<Index>(q), a) = weight(type, rule[q].xi, x);
  }
  return sampling;
}

const Sampling& sampling_of(ElementType type) {
  constexpr std::size_t n_types = static_cast<std::size_t>(ElementType::hex27) + 1;
  static const auto table = [] {
    std::array<Sampling, n_types> all;
    for (std::size_t i = 0; i < n_types; ++i) all[i] = sample(static_cast<ElementType>(i));
    return all;
  }();
  return table[static_cast<std::size_t>(type)];
}

Eigen::Matrix<double, 6, 1> stress_of(const Elasticity& material, const Matrix3& H) {
  const Matrix3 s = material.stress(0.5 * (H + H.transpose()));
  return {s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0)};
}

// n x 6, from H_ab = du_a/dx_b at each sampling point.
template <class Gradients>
Matrix nodal_stress(const Sampling& sampling, const std::vector<Elasticity>& material,
                    const Gradients& H) {
  Matrix at_points(6, sampling.at_nodes.rows());
  for (Index q = 0; q < at_points.cols(); ++q)
    at_points.col(q) = stress_of(material[material.size() == 1 ? 0 : q], H[q]);
  return (at_points * sampling.at_nodes).transpose();
}

}  // namespace

Matrix element_nodal_stress(ElementType type, HexFormulation hex, const Points& X,
                            const Material& material, const Points& u) {
  const Sampling& sampling = sampling_of(type);
  if (type == ElementType::hex8 && has_one_point(hex))
    return element_stress(type, hex, X, material, u).transpose().replicate(8, 1);
  const std::vector<Elasticity> elasticity = isoparametric::elasticities(material, X, sampling.N);
  return isoparametric::with_node_count(type, [&](auto n) -> Matrix {
    const Nodes<n()> local = isoparametric::local_coordinates<n()>(X),
                     motion = isoparametric::local_coordinates<n()>(u);
    if constexpr (n() == 8) {
      if (hex == HexFormulation::incompatible)
        return nodal_stress(sampling, elasticity,
                            hex8_incompatible_gradients(local, elasticity, motion));
    }
    std::vector<Matrix3> H;
    for (const Points& dN : sampling.dN) {
      const Nodes<n()> g =
          isoparametric::gradient<n()>(dN, isoparametric::jacobian<n()>(local, dN));
      H.emplace_back(motion.transpose().lazyProduct(g));
    }
    return nodal_stress(sampling, elasticity, H);
  });
}

Matrix shell_stress(ElementType type, const Points& X, const ShellProperties& shell) {
  const shell::Plane plane = shell::flatten(type, X);
  const Index n = X.rows();
  const double nu = shell.material.poissons_ratio, t = shell.thickness / plane.length;
  // The motion of nodes' projections on the mean plane, in it and across it
  Matrix in_plane = Matrix::Zero(3 * n, 6 * n), across = in_plane;
  for (Index i = 0; i < n; ++i) {
    const Index u = 3 * i, theta = 3 * n + 3 * i;
    in_plane.block<2, 3>(3 * i, u) = plane.axes.topRows<2>() / plane.length;
    across.block<1, 3>(3 * i, u) = plane.axes.row(2) / plane.length;
    in_plane.block<3, 3>(3 * i, theta) << -plane.z[i] * plane.axes.row(1),
        plane.z[i] * plane.axes.row(0), plane.axes.row(2);
    across.block<2, 3>(3 * i + 1, theta) = plane.axes.topRows<2>();
  }
  const Matrix strain = shell::mean_strains(plane) * in_plane,
               curvature = shell::mean_curvatures(plane, nu, t) * across;
  Matrix3 C;
  C << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  C *= shell.material.youngs_modulus / (1 - nu * nu);
  Eigen::Matrix<double, 6, 3> turned;  // of xx, yy, xy of the plane
  const Vector3 x = plane.axes.row(0).transpose(), y = plane.axes.row(1).transpose();
  const auto column = [](const Matrix3& s) {
    return Eigen::Matrix<double, 6, 1>(s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0));
  };
  turned << column(x * x.transpose()), column(y * y.transpose()),
      column(x * y.transpose() + y * x.transpose());
  Matrix faces(12, 6 * n);
  faces << turned * C * (strain + t / 2 * curvature), turned * C * (strain - t / 2 * curvature);
  return faces;
}

}  // namespace cbr
