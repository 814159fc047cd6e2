// SPDX-License-Identifier: GPL-3.0-or-later
// Viscous damping of a body: Rayleigh's, C = alpha M + beta K, and ratios of its modes.
#pragma once

#include <cstddef>

#include "common/base/types.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

// Rates c of eta'' + c eta' + omega^2 eta = f, and a hash of them that is not 0.
struct ModalRates {
  Vector c;              // n, 1/s
  std::size_t hash = 0;  // 0: no damping
};

struct Damping {
  MaterialDamping material;
  ModalDamping modal;

  bool none() const { return material == MaterialDamping() && modal.empty(); }
  // Whether there is damping that only modes can have.
  bool needs_modes() const { return material.loss_factor > 0 || !modal.empty(); }
  // c_j = alpha + beta omega_j^2 + (2 ratio(omega_j) + loss factor) omega_j.
  ModalRates rates(const Vector& omega) const;
};

// Central differences with the stiffness part of the damping taken half a step late are stable for
// h up to 2 over this, rad/s: omega (sqrt(1 + zeta^2) + zeta), zeta = beta omega / 2 (Belytschko,
// Liu, Moran, Nonlinear Finite Elements, 6.2.13).
double critical_frequency(double omega, double beta);

}  // namespace cbr
