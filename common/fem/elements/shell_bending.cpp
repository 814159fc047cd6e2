// SPDX-License-Identifier: GPL-3.0-or-later
// Discrete Kirchhoff-Mindlin: DKMT and DKMQ (Katili 1993, doi 10.1002/nme.1620361106
// and 10.1002/nme.1620361107), which are DKT (Batoz, Bathe, Ho 1980, doi 10.1002/nme.1620151205)
// and DKQ (Batoz, Tahar 1982, doi 10.1002/nme.1620181205) for t -> 0 and keep the frequencies of
// thick shells bounded.

#include "common/fem/elements/shell_plane.hpp"

namespace cbr::shell {
namespace {

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

}  // namespace cbr::shell
