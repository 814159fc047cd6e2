// SPDX-License-Identifier: GPL-3.0-or-later
// Coulomb's law at one point, exactly.
#pragma once

#include "common/base/types.hpp"

namespace cbr {

// gap = q + B p with B (3 x 3) the point's block of W: symmetric, positive semi-definite, B_nn > 0;
// normal first. When it slips, the slip is -alpha p_t with alpha > 0, so that p_t(alpha) = -(S +
// alpha I)^-1 b with S the Schur complement of the normal row, and |p_t(alpha)| = mu p_n(alpha). A
// root exists: sticking (alpha = 0) leaves the cone, p_t = 0 (infinity) is inside.
class CoulombPoint {
 public:
  CoulombPoint() = default;
  CoulombPoint(const Matrix3& B, double friction);
  // p of the law, for this q: open when q_n >= 0, else sticking when the cone allows, else sliding.
  Vector3 solve(const Vector3& q) const;

 private:
  double normal(const Vector3& q, const Eigen::Vector2d& tangential) const;
  Matrix3 B_ = Matrix3::Identity();
  double friction_ = 0;
  Eigen::Matrix2d axes_ = Eigen::Matrix2d::Identity();  // eigenvectors of S, columns
  Eigen::Vector2d s_ = Eigen::Vector2d::Ones();         // its eigenvalues, not negative
};

}  // namespace cbr
