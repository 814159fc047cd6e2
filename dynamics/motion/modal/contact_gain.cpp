// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/contact_gain.hpp"

#include <cassert>
#include <cmath>
#include <numbers>

#include "dynamics/motion/modal/forms/modal_propagator.hpp"

namespace cbr {

Vector contact_gain(const Vector& omega, double h) {
  Vector gain(omega.size());
  for (Index j = 0; j < omega.size(); ++j) {
    const double x = 0.5 * omega[j] * h;
    assert(x < 0.5 * std::numbers::pi);
    gain[j] = x < 1e-4 ? 1 + x * x / 3 : std::tan(x) / x;
  }
  return gain;
}

Vector contact_gain(const Vector& omega, const Vector& damping, Index n_rigid, double h) {
  Vector gain = Vector::Ones(omega.size());
  for (Index j = n_rigid; j < omega.size(); ++j) {
    const DampedStep of = damped_step(omega[j] * h, damping[j] * h);
    gain[j] = (of.P1 * (1 - of.slope) + of.G * of.G) / of.G;
  }
  return gain;
}

}  // namespace cbr
