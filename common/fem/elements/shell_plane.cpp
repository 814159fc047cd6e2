// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/shell_plane.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cassert>
#include <cmath>

#include "common/linalg/dense.hpp"

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

namespace {

// Bending is discrete Kirchhoff-Mindlin: DKMT and DKMQ (Katili 1993, doi 10.1002/nme.1620361106
// and 10.1002/nme.1620361107), which are DKT (Batoz, Bathe, Ho 1980, doi 10.1002/nme.1620151205)
// and DKQ (Batoz, Tahar 1982, doi 10.1002/nme.1620181205) for t -> 0 and keep the frequencies of
// thick shells bounded.
//
// Rotations beta_x = theta_y, beta_y = -theta_x carry the fibre (u = z beta_x, v = z beta_y). Along
// side k they are linear plus 4 s (1 - s) dbeta_k in the side's direction, and the shear strain
// gamma_k is constant:
//   gamma_k = g_k + 2/3 dbeta_k,  g_k = (w_j - w_i) / l + (beta_i + beta_j) / 2,
//   and by the side's equilibrium gamma_k = -2/3 phi_k dbeta_k,  phi_k = 12 D / (kappa G t l^2).
struct Sides {
  Matrix dbeta, gamma;                             // n x 3 n: of the nodal dofs
  Eigen::Matrix<double, Eigen::Dynamic, 2> along;  // n, unit vectors
  Vector length;                                   // n
};

Sides sides(const Plane& plane, double bending, double shear) {
  const Index n = plane.x.rows();
  Sides s{Matrix::Zero(n, 3 * n), Matrix::Zero(n, 3 * n), plane.x, Vector(n)};
  for (Index k = 0; k < n; ++k) {
    const Index j = (k + 1) % n;
    const Eigen::RowVector2d d = plane.x.row(j) - plane.x.row(k);
    s.length(k) = d.norm();
    s.along.row(k) = d / s.length(k);
    Eigen::RowVectorXd g = Eigen::RowVectorXd::Zero(3 * n);
    g(3 * k) = -1 / s.length(k);
    g(3 * j) = 1 / s.length(k);
    for (const Index i : {k, j}) g.segment<2>(3 * i + 1) << -s.along(k, 1) / 2, s.along(k, 0) / 2;
    const double phi = 12 * bending / (shear * s.length(k) * s.length(k));
    s.dbeta.row(k) = -1.5 / (1 + phi) * g;
    s.gamma.row(k) = phi / (1 + phi) * g;
  }
  return s;
}

double rigidity(double nu, double thickness) {
  return thickness * thickness / (12 * (1 - nu * nu));  // D / (E t length^2)
}

double shear_rigidity(double nu) { return 5.0 / 6 / (2 * (1 + nu)); }  // kappa G / E

// Curvatures beta_x,x  beta_y,y  beta_x,y + beta_y,x   (3 x 3 n)
Matrix curvatures(const PlanePoint& point, const Sides& s) {
  const Index n = s.length.size();
  Matrix B = Matrix::Zero(3, 3 * n);
  Eigen::Matrix3Xd side_curvature(3, n);
  for (Index i = 0; i < n; ++i) {
    const double dx = point.dN(i, 0), dy = point.dN(i, 1);
    B.col(3 * i + 1) << 0, -dy, -dx;
    B.col(3 * i + 2) << dx, 0, dy;
    const double c = s.along(i, 0), d = s.along(i, 1);
    side_curvature.col(i) << point.dP(i, 0) * c, point.dP(i, 1) * d,
        point.dP(i, 1) * c + point.dP(i, 0) * d;
  }
  return B + side_curvature * s.dbeta;
}

}  // namespace

Matrix mean_curvatures(const Plane& plane, double nu, double thickness) {
  const Sides s = sides(plane, rigidity(nu, thickness), shear_rigidity(nu));
  Matrix B = Matrix::Zero(3, 3 * plane.x.rows());
  double area = 0;
  for (const PlanePoint& point : plane_points(plane)) {
    area += point.weight;
    B += point.weight * curvatures(point, s);
  }
  return B / area;
}

Matrix bending_stiffness(const Plane& plane, double nu, double thickness) {
  const Index n = plane.x.rows();
  const double bending = rigidity(nu, thickness), shear = shear_rigidity(nu);
  const Sides s = sides(plane, bending, shear);
  Matrix3 C;
  C << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  Matrix K = Matrix::Zero(3 * n, 3 * n);
  for (const PlanePoint& point : plane_points(plane)) {
    const Matrix B = curvatures(point, s);
    // gamma_x, gamma_y   (2 x 3 n)
    const Matrix B_s = point.edge.transpose() * s.length.asDiagonal() * s.gamma;
    K += (point.weight * bending) * B.transpose() * C * B +
         (point.weight * shear) * B_s.transpose() * B_s;
  }
  return K;
}

// Linear triangle; bilinear quad with Wilson's incompatible modes in Taylor's corrected form
// (Taylor, Beresford, Wilson 1976, doi 10.1002/nme.1620100602). Both with rotations tied to those
// of the continuum (Hughes, Brezzi 1989, doi 10.1016/0045-7825(89)90124-2).
Matrix membrane_stiffness(const Plane& plane, double nu) {
  const Index n = plane.x.rows(), n_incompatible = n == 4 ? 4 : 0;
  const double mu = 1 / (2 * (1 + nu));
  // Plane stress of eps_xx, eps_yy, gamma_xy; below it the modulus of theta - (v,x - u,y) / 2.
  Eigen::Matrix4d D = Eigen::Matrix4d::Zero();
  D.topLeftCorner<2, 2>() << 1, nu, nu, 1;
  D.topLeftCorner<2, 2>() /= 1 - nu * nu;
  D(2, 2) = mu;
  D(3, 3) = drilling_modulus * mu;

  Matrix K = Matrix::Zero(3 * n + n_incompatible, 3 * n + n_incompatible);
  for (const PlanePoint& point : plane_points(plane)) {
    Matrix B = Matrix::Zero(4, K.cols());
    const auto displace = [&B](Index column, double dx, double dy) {
      B.col(column) << dx, 0, dy, dy / 2;
      B.col(column + 1) << 0, dy, dx, -dx / 2;
    };
    for (Index i = 0; i < n; ++i) {
      displace(3 * i, point.dN(i, 0), point.dN(i, 1));
      B(3, 3 * i + 2) = point.N(i);
    }
    // The rotation of the incompatible modes counts too: pure bending of a rectangle stays exact.
    for (Index k = 0; k < n_incompatible / 2; ++k)
      displace(3 * n + 2 * k, point.dI(k, 0), point.dI(k, 1));
    K += point.weight * B.transpose() * D * B;
  }
  if (n_incompatible == 0) return K;
  // K_uu - K_ua K_aa^-1 K_au   (12 x 12)
  Matrix Y = K.bottomLeftCorner(4, 3 * n);
  Cholesky(K.bottomRightCorner(4, 4)).solve_lower_in_place(Y);
  return K.topLeftCorner(3 * n, 3 * n) - Y.transpose() * Y;
}

Matrix mean_strains(const Plane& plane) {
  const Index n = plane.x.rows();
  Matrix B = Matrix::Zero(3, 3 * n);
  double area = 0;
  for (const PlanePoint& point : plane_points(plane)) {
    area += point.weight;
    for (Index i = 0; i < n; ++i) {
      const double dx = point.weight * point.dN(i, 0), dy = point.weight * point.dN(i, 1);
      B.col(3 * i) += Vector3(dx, 0, dy);
      B.col(3 * i + 1) += Vector3(0, dy, dx);
    }
  }
  return B / area;
}

}  // namespace cbr::shell
