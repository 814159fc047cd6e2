// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/free_turn.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cbr {
namespace {

constexpr double largest_part = 0.1;  // rad
// The series converges up to a radian and more: 0.1^15 is below round-off.
constexpr int highest_order = 14;

// Of a part of `angle` at most: angle^(order + 1) is 1e-17, below round-off.
int order_of(double angle) {
  constexpr double digits = 17;
  if (!(angle > 0)) return 2;  // keeps values that are not finite
  const double n = std::ceil(digits / -std::log10(std::min(angle, largest_part)));
  return static_cast<int>(std::clamp(n, 2.0, static_cast<double>(highest_order)));
}

}  // namespace

FreeTurn::FreeTurn(const TurnInertia& of)
    : TurnInertia{0.5 * (of.J + of.J.transpose()), of.inner},
      J_inverse(J.inverse()),
      rate_per_momentum(J_inverse.norm()) {}

FreeTurn FreeTurn::between(const TurnInertia& from, const TurnInertia& to, double share) {
  return FreeTurn(TurnInertia{(1 - share) * from.J + share * to.J,
                              (1 - share) * from.inner + share * to.inner});
}

Vector3 FreeTurn::angular_velocity(const Eigen::Quaterniond& q, const Vector3& L) const {
  return q * Vector3(J_inverse * (q.conjugate() * L - inner));
}

Vector3 FreeTurn::change(const Eigen::Quaterniond& q, const Vector3& change_of_L) const {
  return q * Vector3(J_inverse * (q.conjugate() * change_of_L));
}

double FreeTurn::energy(const Eigen::Quaterniond& q, const Vector3& L) const {
  return 0.5 * (L - q * inner).dot(angular_velocity(q, L));
}

Eigen::Quaterniond FreeTurn::turned(const Eigen::Quaterniond& q, const Vector3& L, double h) const {
  const double angle = rate_per_momentum * (L.norm() + inner.norm()) * h;
  if (angle == 0) return q;
  const double n_parts = std::ceil(std::abs(angle) / largest_part);
  const double part = h / n_parts;
  const int order = order_of(std::abs(angle) / n_parts);
  Eigen::Quaterniond now = q;
  for (double i = 0; i < n_parts; ++i) {
    // l = sum l_n t^n, w = J^-1 l, l' = l x w; q = q_0 sum e_n t^n, e' = e w / 2   (n = 0 .. order)
    std::array<Vector3, highest_order + 1> l, w;
    std::array<Eigen::Vector4d, highest_order + 1> e;  // x y z, then the scalar
    l[0] = now.conjugate() * L;
    e[0] << 0, 0, 0, 1;
    Eigen::Vector4d sum = e[0];
    double power = 1;
    for (int n = 0; n < order; ++n) {
      w[n] = J_inverse * (n > 0 ? l[n] : Vector3(l[n] - inner));
      Vector3 l_rate = Vector3::Zero();
      Eigen::Vector4d e_rate = Eigen::Vector4d::Zero();
      for (int k = 0; k <= n; ++k) {
        const Vector3 v = e[k].head<3>();
        l_rate += l[k].cross(w[n - k]);
        e_rate.head<3>() += e[k][3] * w[n - k] + v.cross(w[n - k]);
        e_rate[3] -= v.dot(w[n - k]);
      }
      l[n + 1] = l_rate / (n + 1);
      e[n + 1] = e_rate / (2 * (n + 1));
      power *= part;
      sum += power * e[n + 1];
    }
    // L stays in the scene's axes, so l is always taken from q: no error of l is carried on
    now = (now * Eigen::Quaterniond(sum)).normalized();
  }
  return now;
}

}  // namespace cbr
