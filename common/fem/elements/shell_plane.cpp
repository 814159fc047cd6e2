// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/shell_plane.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cassert>
#include <cmath>

namespace cbr::shell {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Corners = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

// The longest distance between two nodes; 0 when a coordinate is not finite.
double extent(const Points& X) {
  double longest = 0;
  for (Index i = 0; i < X.rows(); ++i)
    for (Index j = 0; j < i; ++j) longest = std::max(longest, (X.row(i) - X.row(j)).stableNorm());
  return X.allFinite() && std::isfinite(longest) ? longest : 0;
}

// From the first node, in units of the extent: an element far from the origin loses no digits.
Corners dimensionless(const Points& X, double length) { return (X.rowwise() - X.row(0)) / length; }

// Along the normal; its length is twice the area of the projection along it.
Vector3 area_vector(const Corners& x) {
  const Index last = x.rows() - 1;
  const Vector3 a = last == 2 ? x.row(1) - x.row(0) : x.row(2) - x.row(0);
  const Vector3 b = last == 2 ? x.row(2) - x.row(0) : x.row(3) - x.row(1);
  return a.cross(b);
}

Vector2d side(const Plane& plane, Index k) {
  return (plane.x.row((k + 1) % plane.x.rows()) - plane.x.row(k)).transpose();
}

std::vector<PlanePoint> triangle_points(const Plane& plane) {
  const Vector2d a = side(plane, 0), b = -side(plane, 2);
  const double twice_area = a(0) * b(1) - a(1) * b(0);
  assert(twice_area > 0);
  PlanePoint point;
  point.weight = twice_area / 6;
  point.dN.resize(3, 2);
  for (Index i = 0; i < 3; ++i) {
    const Vector2d opposite = side(plane, (i + 1) % 3);
    point.dN.row(i) << -opposite(1) / twice_area, opposite(0) / twice_area;
  }
  std::vector<PlanePoint> points;
  for (int q = 0; q < 3; ++q) {
    point.N = Vector::Constant(3, 1.0 / 6);
    point.N(q) = 2.0 / 3;
    point.dP.resize(3, 2);
    point.edge.resize(3, 2);
    for (int k = 0; k < 3; ++k) {
      const int j = (k + 1) % 3;
      point.dP.row(k) = 4 * (point.N(k) * point.dN.row(j) + point.N(j) * point.dN.row(k));
      point.edge.row(k) = point.N(k) * point.dN.row(j) - point.N(j) * point.dN.row(k);
    }
    points.push_back(point);
  }
  return points;
}

constexpr std::array<double, 4> corner_xi = {-1, 1, 1, -1}, corner_eta = {-1, -1, 1, 1};

// d/dxi, d/deta of the bilinear functions.
PlanePoint::Slopes bilinear_slopes(double xi, double eta) {
  PlanePoint::Slopes d(4, 2);
  for (std::size_t i = 0; i < 4; ++i)
    d.row(static_cast<Index>(i)) << corner_xi[i] * (1 + eta * corner_eta[i]) / 4,
        corner_eta[i] * (1 + xi * corner_xi[i]) / 4;
  return d;
}

// J(k, c) = dx_c / dxi_k
Matrix2d quad_jacobian(const Plane& plane, double xi, double eta) {
  return bilinear_slopes(xi, eta).transpose() * plane.x;
}

PlanePoint quad_point(const Plane& plane, double xi, double eta) {
  const Matrix2d J = quad_jacobian(plane, xi, eta), J_0 = quad_jacobian(plane, 0, 0);
  const Matrix2d to_x = J.inverse().transpose();  // d/dx = J^-1 d/dxi, as rows: times J^-T
  PlanePoint point;
  point.weight = J.determinant();
  assert(point.weight > 0);
  point.N.resize(4);
  for (std::size_t i = 0; i < 4; ++i)
    point.N(static_cast<Index>(i)) = (1 + xi * corner_xi[i]) * (1 + eta * corner_eta[i]) / 4;
  point.dN = bilinear_slopes(xi, eta) * to_x;
  PlanePoint::Slopes dP(4, 2), edge(4, 2), dI(2, 2);
  dP << -xi * (1 - eta), (xi * xi - 1) / 2, (1 - eta * eta) / 2, -eta * (1 + xi), -xi * (1 + eta),
      (1 - xi * xi) / 2, (eta * eta - 1) / 2, -eta * (1 - xi);
  edge << (1 - eta) / 4, 0, 0, (1 + xi) / 4, -(1 + eta) / 4, 0, 0, -(1 - xi) / 4;
  dI << -2 * xi, 0, 0, -2 * eta;
  point.dP = dP * to_x;
  point.edge = edge * to_x;
  point.dI = J_0.determinant() / point.weight * dI * J_0.inverse().transpose();
  return point;
}

}  // namespace

Plane flatten(ElementType type, const Points& X) {
  assert((type == ElementType::tri3 || type == ElementType::quad4) && X.rows() == n_nodes(type));
  (void)type;
  Plane plane;
  plane.length = extent(X);
  const Corners x = dimensionless(X, plane.length);
  const Vector3 normal = area_vector(x).normalized();
  // Towards the middle of the side opposite to node 0: any direction in the plane would do, all is
  // isotropic.
  Vector3 along = x.row(1) - x.row(0);
  if (x.rows() == 4) along += (x.row(2) - x.row(3)).transpose();
  along = (along - normal.dot(along) * normal).normalized();
  plane.axes << along.transpose(), normal.cross(along).transpose(), normal.transpose();
  const Corners local = x * plane.axes.transpose();
  plane.x = local.leftCols(2);
  plane.z =
      local.rows() == 4 ? Vector(local.col(2).array() - local.col(2).mean()) : Vector::Zero(3);
  return plane;
}

double corner_jacobian(ElementType type, const Points& X) {
  const double length = extent(X);
  if (!(length > 0)) return 0;
  const double twice_area = area_vector(dimensionless(X, length)).norm();
  if (!(twice_area > 0) || type == ElementType::tri3) return twice_area;
  const Plane plane = flatten(type, X);
  double smallest = twice_area;
  for (std::size_t i = 0; i < 4; ++i)
    smallest =
        std::min(smallest, 4 * quad_jacobian(plane, corner_xi[i], corner_eta[i]).determinant());
  return smallest;
}

std::vector<PlanePoint> plane_points(const Plane& plane) {
  if (plane.x.rows() == 3) return triangle_points(plane);
  const double a = 1 / std::sqrt(3.0);
  std::vector<PlanePoint> points;
  for (std::size_t q = 0; q < 4; ++q)
    points.push_back(quad_point(plane, a * corner_xi[q], a * corner_eta[q]));
  return points;
}

}  // namespace cbr::shell
