// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/elements/shell_stress.hpp"

#include "common/fem/elements/shell_plane.hpp"

namespace cbr {

Matrix shell_stress(ElementType type, const Points& X, const ShellProperties& shell,
                    const Points& u, const Points& theta) {
  const shell::Plane plane = shell::flatten(type, X);
  const Index n = X.rows();
  const double nu = shell.material.poissons_ratio, t = shell.thickness / plane.length;
  Vector in_plane(3 * n), across(3 * n);
  for (Index i = 0; i < n; ++i) {
    const Vector3 rotation = plane.axes * theta.row(i).transpose(),
                  moved = plane.axes * u.row(i).transpose() / plane.length;
    // Of the node's projection on the mean plane
    in_plane.segment<3>(3 * i) << moved[0] - plane.z[i] * rotation[1],
        moved[1] + plane.z[i] * rotation[0], rotation[2];
    across.segment<3>(3 * i) << moved[2], rotation[0], rotation[1];
  }
  const Vector3 strain = shell::mean_strains(plane) * in_plane,
                curvature = shell::mean_curvatures(plane, nu, t) * across;
  Matrix3 C;
  C << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  C *= shell.material.youngs_modulus / (1 - nu * nu);
  Matrix faces(3, 6);
  for (Index face = 0; face < 3; ++face) {
    const double z = (1 - static_cast<double>(face)) * t / 2;
    const Vector3 local = C * (strain + z * curvature);
    Matrix3 sigma = Matrix3::Zero();
    sigma.topLeftCorner<2, 2>() << local[0], local[2], local[2], local[1];
    sigma = plane.axes.transpose() * sigma * plane.axes;
    faces.row(face) << sigma(0, 0), sigma(1, 1), sigma(2, 2), sigma(0, 1), sigma(1, 2), sigma(2, 0);
  }
  return faces;
}

}  // namespace cbr
