// SPDX-License-Identifier: GPL-3.0-or-later
// The rotation of a free rigid body, of any inertia and by any angle.
#pragma once

#include <Eigen/Geometry>

#include "common/base/types.hpp"

namespace cbr {

// J: 3 x 3, inertia about the centre of mass in body axes, kg m^2, positive definite. inner: what
// moves inside the body has of its angular momentum L, body axes: L = R (J w + inner).
struct TurnInertia {
  Matrix3 J = Matrix3::Identity();
  Vector3 inner = Vector3::Zero();
};

struct FreeTurn : TurnInertia {
  Matrix3 J_inverse = Matrix3::Identity();
  double rate_per_momentum = 0;  // the largest |J^-1 l| / |l|

  FreeTurn() = default;
  explicit FreeTurn(const Matrix3& inertia) : FreeTurn(TurnInertia{inertia}) {}
  explicit FreeTurn(const TurnInertia& of);
  // (1 - share) from + share to
  static FreeTurn between(const TurnInertia& from, const TurnInertia& to, double share);

  // R J^-1 (R^T L - inner), rad/s, scene axes. q: unit quaternion of R, body axes to scene axes.
  Vector3 angular_velocity(const Eigen::Quaterniond& q, const Vector3& L) const;
  // by which the former changes as L does
  Vector3 change(const Eigen::Quaterniond& q, const Vector3& change_of_L) const;
  double energy(const Eigen::Quaterniond& q, const Vector3& L) const;  // w . J w / 2

  // q a time h later. L: angular momentum about the centre of mass, scene axes, which stays.
  // Taylor series of Euler's equations and of q' = q w / 2, in parts of at most a tenth of a
  // radian: errors are round-off.
  Eigen::Quaterniond turned(const Eigen::Quaterniond& q, const Vector3& L, double h) const;
};

}  // namespace cbr
