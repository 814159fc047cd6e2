// SPDX-License-Identifier: GPL-3.0-or-later
// Friction laws: the coefficient mu over the slip speed v (length per time, from 0), and its
// derivative. One struct a law.
#pragma once

#include <cmath>
#include <variant>

#include "common/scene/scene.hpp"

namespace cbr {

// Coulomb's law: the same at any speed.
struct ConstantFriction {
  double mu = 0;
  double coefficient(double) const { return mu; }
  double slope(double) const { return 0; }
};

// mu(v) = mu_k + (mu_s - mu_k) exp(-d v), d a time per length: FS, FD and DC of LS-DYNA's contact,
// "exponential decay" of Abaqus.
struct DecayingFriction {
  double mu_s = 0, mu_k = 0, d = 0;
  double coefficient(double v) const { return mu_k + (mu_s - mu_k) * std::exp(-d * v); }
  double slope(double v) const { return -d * (mu_s - mu_k) * std::exp(-d * v); }
};

// Whether the impulse p of a point (normal first) is at Coulomb's limit, but for round-off.
inline bool slides(const Vector3& p, double mu) {
  constexpr double at_limit = 1 - 1e-6;
  return p.tail<2>().norm() >= at_limit * mu * p[0];
}

class FrictionLaw {
 public:
  FrictionLaw() = default;
  explicit FrictionLaw(const FrictionOptions& of) {
    law_ = ConstantFriction{of.at_rest};
    if (of.kinetic) law_ = DecayingFriction{of.at_rest, *of.kinetic, *of.decay};
  }
  double coefficient(double v) const {
    return std::visit([v](const auto& law) { return law.coefficient(v); }, law_);
  }
  double slope(double v) const {
    return std::visit([v](const auto& law) { return law.slope(v); }, law_);
  }
  bool varies() const { return !std::holds_alternative<ConstantFriction>(law_); }

 private:
  std::variant<ConstantFriction, DecayingFriction> law_;
};

}  // namespace cbr
