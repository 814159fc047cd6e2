// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/laws/coulomb_point.hpp"

#include <algorithm>
#include <cmath>

#include "common/linalg/dense.hpp"

namespace cbr {

CoulombPoint::CoulombPoint(const Matrix3& B, double friction) : B_(B), friction_(friction) {
  // S = B_tt - B_tn B_nt / B_nn   (2 x 2)
  const Matrix2 S =
      B.bottomRightCorner<2, 2>() - B.block<2, 1>(1, 0) * B.block<1, 2>(0, 1) / B(0, 0);
  const SymmetricEigen2 eigen = symmetric_eigen2(0.5 * (S + S.transpose()));
  axes_ = eigen.vectors;
  s_ = eigen.values.cwiseMax(0);
}

double CoulombPoint::normal(const Vector3& q, const Eigen::Vector2d& tangential) const {
  return (-q[0] - B_.block<1, 2>(0, 1).dot(tangential.transpose())) / B_(0, 0);
}

Vector3 CoulombPoint::solve(const Vector3& q) const {
  if (q[0] >= 0) return Vector3::Zero();
  // b = q_t - B_tn q_n / B_nn, in the axes of S
  const Eigen::Vector2d b =
      axes_.transpose() * (q.tail<2>() - B_.block<2, 1>(1, 0) * (q[0] / B_(0, 0)));
  const double size = std::max({B_(0, 0), B_(1, 1), B_(2, 2)});
  const auto tangential = [&](double alpha) -> Eigen::Vector2d {
    Eigen::Vector2d x;
    for (int d = 0; d < 2; ++d) x[d] = b[d] == 0 ? 0.0 : -b[d] / (s_[d] + alpha);
    return axes_ * x;
  };
  // > 0: the cone is left
  const auto excess = [&](const Eigen::Vector2d& t) {
    return std::hypot(t[0], t[1]) - friction_ * normal(q, t);
  };
  double low = 1e-15 * size;
  Eigen::Vector2d t = tangential(low);
  if (excess(t) > 0) {
    double high = size;
    for (int i = 0; i < 1000 && excess(tangential(high)) > 0; ++i) {
      low = high;
      high *= 8;
    }
    while (low < high / 16) {
      // their product may be beyond a double's reach
      const double middle = std::sqrt(low) * std::sqrt(high);
      const double f = excess(tangential(middle));
      if (f == 0 || !(middle > low && middle < high)) break;
      (f > 0 ? low : high) = middle;
    }
    // Illinois' regula falsi inside the bracket
    double f_low = excess(tangential(low)), f_high = excess(tangential(high));
    double alpha = high;
    int side = 0;
    for (int i = 0; i < 100 && high - low > 4e-16 * high; ++i) {
      alpha = (low * f_high - high * f_low) / (f_high - f_low);
      if (!(alpha > low && alpha < high)) alpha = 0.5 * (low + high);
      const double f = excess(tangential(alpha));
      if (f == 0) break;
      if (f > 0) {
        low = alpha;
        f_low = f;
        if (side == 1) f_high /= 2;
        side = 1;
      } else {
        high = alpha;
        f_high = f;
        if (side == -1) f_low /= 2;
        side = -1;
      }
    }
    t = tangential(alpha);
  }
  const double p_n = std::max(0.0, normal(q, t)), limit = friction_ * p_n;
  const double length = std::hypot(t[0], t[1]);
  if (length > limit) t *= limit / length;
  return {p_n, t[0], t[1]};
}

}  // namespace cbr
