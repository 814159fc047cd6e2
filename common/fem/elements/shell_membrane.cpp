// SPDX-License-Identifier: GPL-3.0-or-later
// Linear triangle; bilinear quad with Wilson's incompatible modes in Taylor's corrected form
// (Taylor, Beresford, Wilson 1976, doi 10.1002/nme.1620100602). Both with rotations tied to those
// of the continuum (Hughes, Brezzi 1989, doi 10.1016/0045-7825(89)90124-2).

#include "common/fem/elements/shell_plane.hpp"
#include "common/linalg/dense.hpp"

namespace cbr::shell {

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
