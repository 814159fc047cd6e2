// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>

#include <random>

#include "common/base/types.hpp"

namespace cbr::test {

// Random numbers independent of the standard library's distributions.
class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 1) / 2147483648.0;
  }
  Index below(Index n) { return static_cast<Index>(random_() % static_cast<unsigned long>(n)); }
  bool once_in(Index n) { return below(n) == 0; }
  Vector3 vector(double s) {
    const double x = uniform(-s, s), y = uniform(-s, s), z = uniform(-s, s);
    return {x, y, z};
  }
  Matrix3 rotation(double angle) {
    const double by = uniform(-angle, angle);
    const Vector3 axis = vector(1) + Vector3(0, 0, 1e-3);
    return Eigen::AngleAxisd(by, axis.normalized()).toRotationMatrix();
  }

 private:
  std::mt19937 random_;
};

}  // namespace cbr::test
